"""What a sensor does to a map: holes, noise and drift."""

import numpy as np
from numpy.typing import NDArray

from footsel.terrain.local_map import cell_offsets

#: Noise of an Intel RealSense D435, standard deviations in [m] at the depth z in [m]: `a + b (z - c)^2` of the depth
#: and `d z` of where an edge appears. A published fit to measurements of that camera.
AXIAL = (0.000611, 0.003587, 0.3515)
LATERAL = 0.01576
#: It sees nothing nearer than this. [m]
NEAREST = 0.28

#: The camera looks down by this much, as those of ANYmal C do (ANYmal B's description has none).
CAMERA_PITCH = float(np.deg2rad(30.0))
#: It stood about as high as the hips and this far behind the map's centre: a camera at the front does not see the
#: ground under the legs, but what the robot is about to walk over. [m]
VIEW_DISTANCE = (0.5, 1.0)
#: What state estimation leaves: standard deviations of a whole map's height, in [m], and of its slope, along each axis.
#: Assumed, not measured.
DRIFT_HEIGHT, DRIFT_SLOPE = 0.003, 0.005


def depth_camera_reading(
    heights: NDArray[np.float32], resolution: float, rng: np.random.Generator
) -> NDArray[np.float32]:
    """A copy of a local map as one image of a D435 gives it, every known cell from a single reading.

    An error of the depth moves a reading along the line of sight, up or down and to and fro; where an edge appears
    beside its place, a cell takes the height of its neighbour. Maps that fuse many images are better than this.

    heights: (n, n) relative to the hip point, i along the heading, NaN = unknown, in [m].
    resolution: side of a cell, in [m].
    """
    cells = heights.shape[0]
    ahead = (np.arange(cells)[:, None] - (cells - 1) / 2) * resolution + rng.uniform(*VIEW_DISTANCE)
    below = -np.nan_to_num(heights.astype(np.float64))
    z = np.maximum(ahead * np.cos(CAMERA_PITCH) + below * np.sin(CAMERA_PITCH), NEAREST)
    offset, scale, centre = AXIAL
    depth_error, edge_error_x, edge_error_y = rng.normal(size=(3, *heights.shape))
    # The pixel is known, so an error of the depth stretches the whole line of sight.
    stretch = depth_error * (offset + scale * (z - centre) ** 2) / z
    source_i = _displaced(0, stretch * ahead + edge_error_x * LATERAL * z, resolution)
    source_j = _displaced(1, edge_error_y * LATERAL * z, resolution)
    source = heights[source_i, source_j]
    # No reading comes from what is unknown, and none is put there.
    hit = np.where(np.isnan(source) | np.isnan(heights), heights, source)
    return np.asarray(hit - stretch * below, dtype=np.float32)


def _displaced(axis: int, error: NDArray[np.float64], resolution: float) -> NDArray[np.intp]:
    """Index along `axis` of the cell that a reading comes from, if it is reported beside it by `error`, in [m]."""
    index = np.indices(error.shape)[axis] - np.rint(error / resolution)
    return np.asarray(np.clip(index, 0, error.shape[axis] - 1), dtype=np.intp)


def lose_cells(heights: NDArray[np.float32], share: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """A copy of a local map with `share` of its cells unknown, beside those that are, of one kind drawn at random.

    The kinds are those of `punch_holes`. heights: (n, n) in [m].
    """
    kind, shape = rng.integers(3), heights.shape
    if kind == 0:
        first_to_go = rng.random(shape)
    elif kind == 1:
        first_to_go = np.min([_blob(shape, rng) for _ in range(rng.integers(1, 6))], axis=0)
    else:
        first_to_go = -_along(shape, rng.uniform(-np.pi, np.pi))
    lost = np.zeros(heights.size, dtype=np.bool_)
    lost[np.argsort(first_to_go, axis=None, kind="stable")[: round(share * heights.size)]] = True
    return np.where(lost.reshape(shape), np.float32(np.nan), heights)


def punch_holes(heights: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """A copy of a local map with unknown cells, of one kind drawn at random.

    Scattered single cells, a few blobs (occlusions), or all beyond a straight border (the edge of what was seen).
    heights: (n, n) in [m].
    """
    kind, shape = rng.integers(3), heights.shape
    if kind == 0:
        unknown = rng.random(shape) < rng.uniform(0.01, 0.3)
    elif kind == 1:
        unknown = np.min([_blob(shape, rng) for _ in range(rng.integers(1, 6))], axis=0) < 1
    else:
        angle, offset = rng.uniform(-np.pi, np.pi), rng.uniform(-0.3, 0.45) * shape[0]
        unknown = _along(shape, angle) > offset
    return np.where(unknown, np.float32(np.nan), heights)


def _blob(shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float64]:
    """Below 1 inside an ellipse somewhere on the map, growing outwards."""
    i, j = np.indices(shape)
    centre = rng.uniform(0, shape)
    angle, long, short = rng.uniform(0, np.pi), rng.uniform(2, 14), rng.uniform(1, 5)
    along = (i - centre[0]) * np.cos(angle) + (j - centre[1]) * np.sin(angle)
    across = -(i - centre[0]) * np.sin(angle) + (j - centre[1]) * np.cos(angle)
    return np.asarray((along / long) ** 2 + (across / short) ** 2)


def _along(shape: tuple[int, ...], angle: float) -> NDArray[np.float64]:
    """How far each cell lies from the map's centre in a direction, in cells."""
    i, j = np.indices(shape)
    return np.asarray((i - shape[0] / 2) * np.cos(angle) + (j - shape[1] / 2) * np.sin(angle))


def drift(cells: int, resolution: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """(cells, cells) what state estimation adds to the heights of a whole local map, a plane, in [m].

    resolution: side of a cell, in [m].
    """
    slope = rng.normal(0, DRIFT_SLOPE, 2)
    return np.asarray(rng.normal(0, DRIFT_HEIGHT) + cell_offsets(cells, resolution) @ slope, dtype=np.float32)
