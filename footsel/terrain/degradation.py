"""What a sensor does to a map: holes. (Noise and drift belong here too once mapping is part of the story.)"""

import numpy as np
from numpy.typing import NDArray


def punch_holes(heights: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    """A copy of a local map with unknown cells, of one kind drawn at random.

    Scattered single cells, a few blobs (occlusions), or all beyond a straight border (the edge of what was seen).
    heights: (n, n) in [m].
    """
    kind = rng.integers(3)
    rows, columns = heights.shape
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    if kind == 0:
        unknown = rng.random(heights.shape) < rng.uniform(0.01, 0.3)
    elif kind == 1:
        unknown = np.zeros(heights.shape, dtype=np.bool_)
        for _ in range(rng.integers(1, 6)):
            centre = rng.uniform(0, [rows, columns])
            angle, long, short = rng.uniform(0, np.pi), rng.uniform(2, 14), rng.uniform(1, 5)
            along = (i - centre[0]) * np.cos(angle) + (j - centre[1]) * np.sin(angle)
            across = -(i - centre[0]) * np.sin(angle) + (j - centre[1]) * np.cos(angle)
            unknown |= (along / long) ** 2 + (across / short) ** 2 < 1
    else:
        angle, offset = rng.uniform(-np.pi, np.pi), rng.uniform(-0.3, 0.45) * rows
        unknown = (i - rows / 2) * np.cos(angle) + (j - columns / 2) * np.sin(angle) > offset
    return np.where(unknown, np.float32(np.nan), heights)
