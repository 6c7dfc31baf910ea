"""Small shapes that a foot may bridge or slip from, one beside the other: what courses for walking hold too little of.

Pits, spikes, grooves, ridges, low steps and noise teach the fit to tell a pit, which holds a foot, from the foot of a
step, which looks the same to a sum of drops.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.terrain import ElevationMap

#: What the courses of this module are called among the terrain families.
SHAPES = "shapes"

CELL = 0.02
#: Side of the square around each shape, in cells: further than a foot and its stencil reach.
TILE = 15
#: Depths and heights are drawn evenly in their logarithm, noise too; slopes of the ground evenly. [m], [m], -
SIZES, NOISE, LARGEST_SLOPE = (0.003, 0.08), (0.0005, 0.012), 0.35

Heights = NDArray[np.float64]


def shape_course(seed: int | np.random.Generator, size: float = 3.0) -> ElevationMap:
    """A square course of tiles of 0.3 m, each with one shape on level or sloping ground; the same for the same seed.

    size: side, in [m].
    """
    rng = np.random.default_rng(seed)
    cells = round(size / CELL)
    tiles = -(-cells // TILE)
    rows = [np.concatenate([_tile(rng) for _ in range(tiles)], axis=1) for _ in range(tiles)]
    return ElevationMap(np.concatenate(rows)[:cells, :cells].astype(np.float32), CELL)


def _tile(rng: np.random.Generator) -> Heights:
    """(TILE, TILE) heights around 0."""
    along = (np.arange(TILE) - (TILE - 1) / 2) * CELL
    x, y = np.meshgrid(along, along, indexing="ij")
    turn = rng.uniform(0, 2 * np.pi)
    across, beside = np.cos(turn) * x + np.sin(turn) * y, np.cos(turn) * y - np.sin(turn) * x
    height = rng.choice([-1, 1]) * _log_uniform(rng, SIZES)
    radius = rng.uniform(0.5, 3.5) * CELL
    heights = np.zeros((TILE, TILE))
    kind = rng.integers(6)
    if kind == 0:  # pit or spike: flat-bottomed or pointed
        distance = np.hypot(x, y)
        heights = height * np.where(distance < radius, 1 - rng.integers(2) * distance / radius, 0.0)
    elif kind == 1:  # groove or ridge
        heights = height * (np.abs(across) < radius / 2)
    elif kind == 2:  # step, to a side or a corner
        heights = height * ((across > 0) & ((beside > 0) | (rng.random() < 0.5)))
    elif kind == 3:  # noise, by the cell
        heights = rng.normal(0, _log_uniform(rng, NOISE), heights.shape)
    elif kind == 4:  # wave
        heights = height / 2 * np.sin(across / rng.uniform(0.015, 0.06))
    # The last kind is the bare ground.
    if rng.random() < 0.5:
        slope, towards = rng.uniform(0, LARGEST_SLOPE), rng.uniform(0, 2 * np.pi)
        heights = heights + slope * (np.cos(towards) * x + np.sin(towards) * y)
    return heights


def _log_uniform(rng: np.random.Generator, bounds: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(bounds))))
