"""A map as a sensor leaves it, without simulating the sensor."""

import numpy as np

from footsel.terrain import CELLS, ElevationMap
from footsel.terrain.degradation import depth_camera_reading, drift, lose_cells

#: How high the camera passes over the ground, in [m].
HEIGHT = 0.45
#: Share of the cells of a tile that are lost, drawn anew for each tile.
LOST = (0.0, 0.2)


def noisy_map(elevation_map: ElevationMap, rng: np.random.Generator) -> ElevationMap:
    """A degraded copy: noise and frayed edges of a depth camera, holes, and a drift of the whole map.

    The course is seen from near all along, so it is read tile by tile, each of the size of a local map and as from its
    near side along x. Drift, that of state estimation, tilts and lifts the whole. No cell becomes known.
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
    nx, ny = heights.shape
    heights += drift(max(nx, ny), resolution, rng)[:nx, :ny]
    return ElevationMap(heights, resolution, elevation_map.position)
