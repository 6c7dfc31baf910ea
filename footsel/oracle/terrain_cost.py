"""The fifth constraint: how likely a foot is to slip on the terrain around a cell, c_m in [0, 1].

As Belter and Skrzypczynski (2011) do, a foothold is judged by two features of its neighbourhood, K1 = sum(h0 - h),
signed (ridge > 0, pit < 0), and K2 = sum|h0 - h|, and its quality is a mixture of Gaussians over (K1, K2) that was
fitted to slippage in simulation. Unlike theirs, the features do not depend on the cell size: the neighbourhood is a
stencil in metres, sampled bilinearly, and a plane of slope t has K2 = t and K1 = 0. A drop counts up to 5 cm,
for a foot that goes over an edge has lost its stand whatever the depth.

The numbers are in terrain_cost.json, which `footsel terrain-cost fit` makes.
"""

import json
from dataclasses import asdict, dataclass
from functools import cache
from importlib import resources
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

DATA_FILE = "terrain_cost.json"

#: The stencil: points this far apart along x and y, in rings of these weights around the cell. [m]
SPACING = 0.02
RING_WEIGHTS = (1.0, 0.5)
#: Differences in height count up to this; a foot that goes over a higher edge slips no further. [m]
LARGEST_DROP = 0.05


@dataclass(frozen=True)
class Gaussian:
    """One component of the quality over (K1, K2), which are slopes. weight: its peak."""

    weight: float
    k1: float
    k2: float
    sigma_k1: float
    sigma_k2: float
    correlation: float


@dataclass(frozen=True)
class TerrainCostModel:
    """c_m = 1 - the sum of Gaussians over (K1, K2), held to [0, 1]."""

    gaussians: tuple[Gaussian, ...]

    def cost(self, k1: ArrayLike, k2: ArrayLike) -> Array:
        """c_m of features of any shape, no neighbour missing."""
        return np.asarray(1 - np.minimum(self.quality(k1, k2), 1.0))

    def quality(self, k1: ArrayLike, k2: ArrayLike) -> Array:
        """The sum of Gaussians, which may pass 1."""
        k1, k2 = np.asarray(k1, dtype=np.float64), np.asarray(k2, dtype=np.float64)
        quality = np.zeros(np.broadcast(k1, k2).shape)
        for g in self.gaussians:
            a, b = (k1 - g.k1) / g.sigma_k1, (k2 - g.k2) / g.sigma_k2
            square = (a * a - 2 * g.correlation * a * b + b * b) / (1 - g.correlation**2)
            quality += g.weight * np.exp(-square / 2)
        return quality

    def packed(self) -> Array:
        """(m, 6) weight, k1, k2, sigma_k1, sigma_k2, correlation."""
        return np.array([list(asdict(g).values()) for g in self.gaussians]).reshape(-1, 6)

    @classmethod
    def load(cls) -> "TerrainCostModel":
        """The model that ships with footsel."""
        return _shipped()

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> "TerrainCostModel":
        """From the data file's values."""
        return cls(tuple(Gaussian(**gaussian) for gaussian in values["gaussians"]))


@cache
def _shipped() -> TerrainCostModel:
    text = (resources.files("footsel.oracle") / DATA_FILE).read_text(encoding="utf-8")
    return TerrainCostModel.from_dict(json.loads(text))


def terrain_costs(heights: NDArray[np.floating], resolution: float) -> Array:
    """(n, m) c_m of every known cell, NaN where unknown. Missing neighbours, those beyond the map included, raise it.

    heights: (n, m) in [m], NaN = unknown. resolution: side of a cell, in [m].
    """
    k1, k2, known = terrain_features(heights, resolution)
    return _costs(k1, k2, known, _shipped_packed())


@cache
def _shipped_packed() -> Array:
    return TerrainCostModel.load().packed()


def terrain_features(heights: NDArray[np.floating], resolution: float) -> tuple[Array, Array, Array]:
    """K1 and K2 (n, m) of every known cell, and the share of its neighbourhood that is known, by weight.

    All three are NaN for unknown cells; K1 and K2 are 0 where no neighbour is known.
    """
    return _features(np.ascontiguousarray(heights, dtype=np.float64), SPACING / resolution)


@numba.njit(cache=True)
def _features(heights: Array, step: float) -> tuple[Array, Array, Array]:  # pragma: no cover - compiled
    """step: distance between the stencil's points, in cells."""
    rows, columns = heights.shape
    rings = len(RING_WEIGHTS)
    # A border of unknown cells, so that no point of the stencil needs to look whether it is on the map.
    border = int(np.ceil(rings * step)) + 1
    padded = np.full((rows + 2 * border, columns + 2 * border), np.nan)
    padded[border : border + rows, border : border + columns] = heights
    signed, absolute, known = np.zeros((3, rows, columns))
    total, slope_response = 0.0, 0.0
    # Point by point over the whole map: the inner loop runs along a row of memory.
    for a in range(-rings, rings + 1):
        for b in range(-rings, rings + 1):
            if a == 0 and b == 0:
                continue
            weight = RING_WEIGHTS[max(abs(a), abs(b)) - 1]
            total += weight
            slope_response += weight * abs(a) * SPACING
            _add_point(heights, padded, border, a * step, b * step, weight, signed, absolute, known)
    for i in range(rows):
        for j in range(columns):
            if np.isnan(heights[i, j]):
                signed[i, j] = absolute[i, j] = known[i, j] = np.nan
            elif known[i, j] > 0.0:
                scale = total / known[i, j] / slope_response
                signed[i, j] *= scale
                absolute[i, j] *= scale
    return signed, absolute, known / total


@numba.njit(cache=True)
def _add_point(
    heights: Array,
    padded: Array,
    border: int,
    x: float,
    y: float,
    weight: float,
    signed: Array,
    absolute: Array,
    known: Array,
) -> None:  # pragma: no cover - compiled
    """Add one point of the stencil, x and y cells away, to the sums of all cells; its height is bilinear.

    If a cell that it needs is unknown, so is the point.
    """
    low_i, low_j = int(np.floor(x + 1e-9)), int(np.floor(y + 1e-9))
    u, v = x - low_i, y - low_j
    between_rows, between_columns = u > 1e-9, v > 1e-9
    rows, columns = heights.shape
    for i in range(rows):
        p, q = i + border + low_i, border + low_j
        for j in range(columns):
            height = padded[p, q + j]
            if between_rows:
                height += u * (padded[p + 1, q + j] - height)
            if between_columns:
                beside = padded[p, q + j + 1]
                if between_rows:
                    beside += u * (padded[p + 1, q + j + 1] - beside)
                height += v * (beside - height)
            drop = heights[i, j] - height
            if not np.isnan(drop):
                drop = min(max(drop, -LARGEST_DROP), LARGEST_DROP)
                signed[i, j] += weight * drop
                absolute[i, j] += weight * abs(drop)
                known[i, j] += weight


@numba.njit(cache=True)
def _costs(k1: Array, k2: Array, known: Array, gaussians: Array) -> Array:  # pragma: no cover - compiled
    costs = 1.0 - 0.0 * known
    quality = np.zeros(known.shape)
    for weight, c1, c2, s1, s2, r in gaussians:
        # The exponent as a quadratic form.
        f = -0.5 / (1 - r * r)
        aa, ab, bb = f / (s1 * s1), -2 * r * f / (s1 * s2), f / (s2 * s2)
        for i in range(k1.shape[0]):
            for j in range(k1.shape[1]):
                a, b = k1[i, j] - c1, k2[i, j] - c2
                quality[i, j] += weight * np.exp(aa * a * a + ab * a * b + bb * b * b)
    for i in range(k1.shape[0]):
        for j in range(k1.shape[1]):
            costs[i, j] -= min(quality[i, j], 1.0) * known[i, j]
    return costs
