"""A map as a sensor leaves it, without simulating the sensor."""

import numpy as np
from numpy.typing import NDArray

from footsel.terrain import CELLS, ElevationMap
from footsel.terrain.degradation import DRIFT_HEIGHT, depth_camera_reading, lose_cells

#: How high the camera passes over the ground, in [m].
HEIGHT = 0.45
#: Share of the cells of a tile that are lost, drawn anew for each tile.
LOST = (0.0, 0.2)


def noisy_map(elevation_map: ElevationMap, rng: np.random.Generator) -> ElevationMap:
    """A degraded copy: noise and frayed edges of a depth camera, holes, and a drift of the whole map.

    The course is seen from near all along, so it is read tile by tile, each of the size of a local map and as from its
    near side along x. The drift changes along the way, and lifts and tilts a local map as much as `degradation.drift`
    does. No cell becomes known.
    """
    resolution = elevation_map.resolution
    heights = elevation_map.elevation.copy()
    for i in range(0, heights.shape[0], CELLS):
        for j in range(0, heights.shape[1], CELLS):
            tile = heights[i : i + CELLS, j : j + CELLS]
            known = tile[~np.isnan(tile)]
            if known.size:
                eye = np.float32(np.median(known) + HEIGHT)
                read = depth_camera_reading(tile - eye, resolution, rng) + eye
                heights[i : i + CELLS, j : j + CELLS] = lose_cells(read, rng.uniform(*LOST), rng)
    heights += _drift(heights.shape, rng)
    return ElevationMap(heights, resolution, elevation_map.position)


def _drift(shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float32]:
    """(nx, ny) lifts drawn for the corners of all tiles, and in between the mean of those around, in [m]."""
    weights = []
    for cells in shape:
        place, corners = np.arange(cells) / CELLS, np.arange(-(-cells // CELLS) + 1)
        weights.append(np.maximum(1 - np.abs(place[:, None] - corners), 0))
    lifts = rng.normal(0, DRIFT_HEIGHT, (weights[0].shape[1], weights[1].shape[1]))
    return np.asarray(weights[0] @ lifts @ weights[1].T, dtype=np.float32)
