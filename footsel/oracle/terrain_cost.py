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
        k1, k2 = np.asarray(k1, dtype=np.float64), np.asarray(k2, dtype=np.float64)
        quality = np.zeros(np.broadcast(k1, k2).shape)
        for g in self.gaussians:
            a, b = (k1 - g.k1) / g.sigma_k1, (k2 - g.k2) / g.sigma_k2
            square = (a * a - 2 * g.correlation * a * b + b * b) / (1 - g.correlation**2)
            quality += g.weight * np.exp(-square / 2)
        return np.asarray(1 - np.minimum(quality, 1.0))

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
    k1, k2, share = np.full((3, rows, columns), np.nan)
    # A stencil point lies between whole cells `low` and `low + 1`, `part` of the way.
    low, part = np.empty(2 * rings + 1, dtype=np.int64), np.empty(2 * rings + 1)
    weights = np.zeros((2 * rings + 1, 2 * rings + 1))
    total, slope_response = 0.0, 0.0
    for a in range(2 * rings + 1):
        offset = (a - rings) * step
        low[a] = int(np.floor(offset + 1e-9))
        part[a] = max(offset - low[a], 0.0)
        if part[a] < 1e-9:
            part[a] = 0.0
        for b in range(2 * rings + 1):
            ring = max(abs(a - rings), abs(b - rings))
            if ring:
                weights[a, b] = RING_WEIGHTS[ring - 1]
                total += weights[a, b]
                slope_response += weights[a, b] * abs(a - rings) * SPACING
    for i in range(rows):
        for j in range(columns):
            centre = heights[i, j]
            if np.isnan(centre):
                continue
            signed, absolute, known = 0.0, 0.0, 0.0
            for a in range(2 * rings + 1):
                for b in range(2 * rings + 1):
                    if weights[a, b] == 0.0:
                        continue
                    height = _between(heights, i + low[a], j + low[b], part[a], part[b])
                    if np.isnan(height):
                        continue
                    drop = min(max(centre - height, -LARGEST_DROP), LARGEST_DROP)
                    signed += weights[a, b] * drop
                    absolute += weights[a, b] * abs(drop)
                    known += weights[a, b]
            share[i, j] = known / total
            scale = total / known / slope_response if known > 0.0 else 0.0
            k1[i, j], k2[i, j] = signed * scale, absolute * scale
    return k1, k2, share


@numba.njit(cache=True)
def _between(heights: Array, i: int, j: int, u: float, v: float) -> float:  # pragma: no cover - compiled
    """Bilinear height u of the way from row i to i + 1 and v from column j to j + 1; NaN if a corner it needs is."""
    rows, columns = heights.shape
    height = 0.0
    for a in range(2):
        for b in range(2):
            weight = (u if a else 1.0 - u) * (v if b else 1.0 - v)
            if weight == 0.0:
                continue
            if not (0 <= i + a < rows and 0 <= j + b < columns):
                return np.nan
            height += weight * heights[i + a, j + b]
    return height


@numba.njit(cache=True)
def _costs(k1: Array, k2: Array, known: Array, gaussians: Array) -> Array:  # pragma: no cover - compiled
    costs = np.full(k1.shape, np.nan)
    for i in range(k1.shape[0]):
        for j in range(k1.shape[1]):
            if np.isnan(known[i, j]):
                continue
            quality = 0.0
            for weight, c1, c2, s1, s2, r in gaussians:
                a, b = (k1[i, j] - c1) / s1, (k2[i, j] - c2) / s2
                quality += weight * np.exp(-(a * a - 2 * r * a * b + b * b) / (2 * (1 - r * r)))
            costs[i, j] = 1.0 - min(quality, 1.0) * known[i, j]
    return costs
