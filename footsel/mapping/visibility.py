"""What a depth image looks through or past: what stood there has gone, or never was."""

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


def doubts(
    depth: NDArray[np.float32], camera: CameraModel, world_camera: Array, points: Array, variance: Array, sight: float
) -> Array:
    """(k,) 1 where the ray to a world point (k, 3) ends lower and beyond it, -1 where it ends at its height, else 0.

    depth: (height, width), 0 is no reading, in [m]. variance: (k,) of the points' heights, in [m^2]. sight: as many
    standard deviations make a difference.

    Beside an edge a pixel may show the surface on its other side, as often here as there: of many images, more show
    what is there than what is not.
    """
    pixels, distance = camera.project((points - world_camera[:3, 3]) @ world_camera[:3, :3])
    inside = np.flatnonzero(((pixels >= 0) & (pixels <= (camera.width - 1, camera.height - 1))).all(axis=1))
    u, v = np.rint(pixels[inside]).astype(np.intp).T
    end = depth[v, u]
    inside, u, v, end = (values[end > 0] for values in (inside, u, v, end))
    rise = world_camera[2, :3] @ camera.rays[:, v * camera.width + u]
    sigma = camera.noise.sigma(end)
    below = points[inside, 2] - (world_camera[2, 3] + rise * end)
    differs = sight * np.sqrt(variance[inside] + (rise * sigma) ** 2)
    beyond = end - distance[inside] > sight * sigma
    found = np.zeros(len(points))
    found[inside] = ((below > differs) & beyond).astype(np.float64) - (np.abs(below) <= differs)
    return found
