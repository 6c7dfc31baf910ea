"""Cells that a depth image looks through: what stood there has gone, or never was."""

import numpy as np
from numpy.typing import NDArray

from footsel.mapping.camera import CameraModel

Array = NDArray[np.float64]


def seen_through(
    depth: NDArray[np.float32], camera: CameraModel, world_camera: Array, points: Array, sight: float
) -> NDArray[np.bool_]:
    """(k,) whether rays pass world points (k, 3) and end behind them.

    depth: (height, width), 0 is no reading, in [m]. sight: so many standard deviations of the depth behind.

    A ray is said to pass only if its eight neighbours do too: a pixel beside an edge shows one thing or the other.
    """
    pixels, distance = camera.project((points - world_camera[:3, 3]) @ world_camera[:3, :3])
    inside = ((pixels >= 1) & (pixels <= (camera.width - 2, camera.height - 2))).all(axis=1)
    through = np.zeros(len(points), dtype=np.bool_)
    u, v = np.rint(pixels[inside]).astype(np.intp).T
    nearest = np.min([depth[v + down, u + right] for down in (-1, 0, 1) for right in (-1, 0, 1)], axis=0)
    through[inside] = nearest - sight * camera.noise.sigma(nearest) > distance[inside]
    return through
