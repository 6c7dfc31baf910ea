"""The fifth constraint: how likely a foot is to slip on the terrain around a cell, c_m in [0, 1].

As Belter and Skrzypczynski (2011) do, a foothold is judged by two features of its neighbourhood, K1 = sum(h0 - h),
signed (ridge > 0, pit < 0), and K2 = sum|h0 - h|, and its quality is a mixture of Gaussians over (K1, K2) that was
fitted to slippage in simulation. Two things are ours:

- h is no height of the ground but of the foot's surface: of a ball that touches the ground there. A foot slides along
  that surface, bridges a pit and is lifted beside a wall, so the two features tell much more (docs/terrain_cost.md).
- The neighbourhood is a stencil in metres, sampled bilinearly, so cell size does not matter; a plane of slope t has
  K2 = t and K1 = 0. A drop counts up to 5 cm, for a foot that goes over an edge has lost its stand whatever the depth.

The numbers are in terrain_cost.json, which `footsel terrain-cost fit` makes.
"""

import json
from dataclasses import asdict, dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.compiled import compiled

Array = NDArray[np.float64]

DATA_FILE = "terrain_cost.json"

#: The stencil: points this far apart along x and y, in rings of these weights around the cell. [m]
SPACING = 0.02
RING_WEIGHTS = (1.0, 0.25)
#: Differences in height count up to this; a foot that goes over a higher edge slips no further. [m]
LARGEST_DROP = 0.05
#: Of the ball that stands for the foot, ANYmal's. It touches the ground within one spacing around. [m]
FOOT_RADIUS = 0.031

_RINGS = range(-len(RING_WEIGHTS), len(RING_WEIGHTS) + 1)
#: (points, 3) offset along x and y, in spacings, and weight of the stencil's points.
STENCIL = np.array([(a, b, RING_WEIGHTS[max(abs(a), abs(b)) - 1]) for a in _RINGS for b in _RINGS if a or b])
#: (points, 3) where else than under its centre a foot may touch, in spacings, and how far it sinks there. [-, -, m]
TOUCHES = np.array(
    [
        (a, b, FOOT_RADIUS - np.sqrt(FOOT_RADIUS**2 - (a * a + b * b) * SPACING**2))
        for a in (-1, 0, 1)
        for b in (-1, 0, 1)
        if a or b
    ]
)
#: What the weighted drops are divided by: their sum on a plane of slope 1.
PLANE = float((STENCIL[:, 2] * np.abs(STENCIL[:, 0])).sum()) * SPACING
#: K1 and K2 of a cell that falls off to all sides.
LARGEST_FEATURE = float(STENCIL[:, 2].sum()) * LARGEST_DROP / PLANE


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
    """(n, m) c_m of every known cell, NaN where unknown.

    Points of the stencil that are unknown or beyond the map raise it: of two readings, that they do not count but
    make the rest less sure, and that they are as deep as a drop can be, the worse one holds.

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
    step = SPACING / resolution
    return _features(_foot_surface(np.ascontiguousarray(heights, dtype=np.float64), step, TOUCHES), step, STENCIL)


def foot_surface(heights: NDArray[np.floating], resolution: float) -> Array:
    """(n, m) height of the lowest point of a foot that touches the ground from above each cell, NaN where unknown.

    Unknown ground holds no foot. On a plane the surface is the plane lifted.
    """
    return _foot_surface(np.ascontiguousarray(heights, dtype=np.float64), SPACING / resolution, TOUCHES)


@compiled
def _foot_surface(heights: Array, step: float, touches: Array) -> Array:  # pragma: no cover - compiled
    """step: distance between points of stencil and touches, in cells."""
    surface: Array = heights.copy()
    for x, y, sinking in touches:
        beside = _shifted(heights, x * step, y * step)
        for i in range(surface.shape[0]):
            for j in range(surface.shape[1]):
                # Comparisons with unknown heights are false.
                if beside[i, j] - sinking > surface[i, j]:  # noqa: PLR1730 - `max` may give the unknown
                    surface[i, j] = beside[i, j] - sinking
    return surface


@compiled
def _features(surface: Array, step: float, stencil: Array) -> tuple[Array, Array, Array]:  # pragma: no cover - compiled
    rows, columns = surface.shape
    signed, absolute, known = np.zeros((3, rows, columns))
    # Point by point over the whole map: the inner loop runs along a row of memory.
    for x, y, weight in stencil:
        beside = _shifted(surface, x * step, y * step)
        for i in range(rows):
            for j in range(columns):
                drop = surface[i, j] - beside[i, j]
                if not np.isnan(drop):
                    drop = min(max(drop, -LARGEST_DROP), LARGEST_DROP)
                    signed[i, j] += weight * drop
                    absolute[i, j] += weight * abs(drop)
                    known[i, j] += weight
    total = stencil[:, 2].sum()
    for i in range(rows):
        for j in range(columns):
            if np.isnan(surface[i, j]):
                signed[i, j] = absolute[i, j] = known[i, j] = np.nan
            elif known[i, j] > 0.0:
                scale = total / known[i, j] / PLANE
                signed[i, j] *= scale
                absolute[i, j] *= scale
    return signed, absolute, known / total


@compiled
def _shifted(surface: Array, x: float, y: float) -> Array:  # pragma: no cover - compiled
    """(n, m) height that each cell sees x and y cells away, bilinear; unknown if a cell that takes part is unknown."""
    low_i, low_j = int(np.floor(x + 1e-9)), int(np.floor(y + 1e-9))
    u, v = x - low_i, y - low_j
    high_i, high_j = low_i + (u > 1e-9), low_j + (v > 1e-9)
    rows, columns = surface.shape
    seen = np.full((rows, columns), np.nan)
    for i in range(max(-low_i, 0), min(rows, rows - high_i)):
        for j in range(max(-low_j, 0), min(columns, columns - high_j)):
            height = surface[i + low_i, j + low_j]
            if high_i > low_i:
                height += u * (surface[i + high_i, j + low_j] - height)
            if high_j > low_j:
                beside = surface[i + low_i, j + high_j]
                if high_i > low_i:
                    beside += u * (surface[i + high_i, j + high_j] - beside)
                height += v * (beside - height)
            seen[i, j] = height
    return seen


@compiled
def _costs(k1: Array, k2: Array, known: Array, gaussians: Array) -> Array:  # pragma: no cover - compiled
    costs = np.full(known.shape, np.nan)
    for i in range(known.shape[0]):
        for j in range(known.shape[1]):
            share = known[i, j]
            if not np.isnan(share):
                quality = _quality(k1[i, j], k2[i, j], gaussians) * share
                if share < 1.0:
                    drop = (1.0 - share) * LARGEST_FEATURE
                    deep = _quality(share * k1[i, j] + drop, share * k2[i, j] + drop, gaussians)
                    quality = min(quality, deep)
                costs[i, j] = 1.0 - quality
    return costs


@compiled
def _quality(k1: float, k2: float, gaussians: Array) -> float:  # pragma: no cover - compiled
    quality = 0.0
    for weight, c1, c2, s1, s2, r in gaussians:
        a, b = (k1 - c1) / s1, (k2 - c2) / s2
        quality += weight * np.exp(-0.5 / (1 - r * r) * (a * a - 2 * r * a * b + b * b))
    return min(quality, 1.0)
