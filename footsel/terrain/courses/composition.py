"""A map composed of tiles of several families, as the paper's training map is."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from footsel.terrain.courses.registry import make_course
from footsel.terrain.elevation_map import ElevationMap

#: Tiles per family on the training map: robot-map like rough ground most, then steps, concavities and bumps, flat
#: ground. The final version of the paper names these ingredients without their shares.
TRAINING_TILES = {
    "rough": 5,
    "rubble": 4,
    "steps": 6,
    "stairs": 3,
    "bumps": 5,
    "blocks": 4,
    "slopes": 3,
    "flat": 3,
    "gaps": 1,
    "stones": 1,
    "pillars": 1,
}
TRAINING_SIZE = 12.0
#: Neighbouring tiles overlap by this much and pass linearly from one to the other, in [m].
SEAM = 0.2


def training_map(
    seed: int | np.random.Generator, resolution: float = 0.02, families: Sequence[str] = tuple(TRAINING_TILES)
) -> ElevationMap:
    """A 12x12 m map of 36 tiles of 2x2 m in random places, after the paper's training map (its figure trainMap).

    families: what it is composed of; where some are left out, the others fill their tiles in turn.
    """
    rng = np.random.default_rng(seed)
    tiles_of = {family: tiles for family, tiles in TRAINING_TILES.items() if family in families}
    all_tiles = np.repeat(list(tiles_of), list(tiles_of.values()))
    spare = sum(TRAINING_TILES.values()) - len(all_tiles)
    order = rng.permutation(np.concatenate([all_tiles, np.resize(list(tiles_of), spare)]))
    tiles = round(np.sqrt(len(order)))
    cells = round(TRAINING_SIZE / resolution)
    tile = TRAINING_SIZE / tiles
    total, weights = np.zeros((cells, cells)), np.zeros((cells, cells))
    for number, family in enumerate(order.tolist()):
        row, column = divmod(number, tiles)
        x, y = ((index + 0.5) * tile - TRAINING_SIZE / 2 for index in (row, column))
        course = make_course(family, rng, size=tile + SEAM + 4 * resolution, resolution=resolution)
        # Levels of neighbours agree where most of their ground is.
        heights = course.elevation - np.median(course.elevation)
        weight = np.outer(_seam_weight(course.x(), tile), _seam_weight(course.y(), tile))
        _add(total, weight * heights, x, y, resolution)
        _add(weights, weight, x, y, resolution)
    return ElevationMap((total / weights).astype(np.float32), resolution)


def _seam_weight(offset: NDArray[np.float64], tile: float) -> NDArray[np.float64]:
    """(n,) share of a tile at an offset from its middle: 1 inside, falling to 0 across the seam."""
    return np.clip((tile / 2 + SEAM / 2 - np.abs(offset)) / SEAM, 0, 1)


def _add(total: NDArray[np.float64], part: NDArray[np.float64], x: float, y: float, resolution: float) -> None:
    """Add a square part whose middle lies at (x, y) to the map in place; what reaches beyond the map is dropped."""
    low = [round(c / resolution + (len(total) - len(part)) / 2) for c in (x, y)]
    first = [max(start, 0) for start in low]
    last = [min(start + len(part), len(total)) for start in low]
    inside = tuple(slice(a - start, b - start) for a, b, start in zip(first, last, low, strict=True))
    total[first[0] : last[0], first[1] : last[1]] += part[inside]
