"""How the maps that a network learns from differ from the ground; the labels stay those of the true ground."""

import numpy as np

from footsel.dataset.samples import Samples
from footsel.learning.degraded import with_heights
from footsel.terrain.degradation import depth_camera_reading, drift, lose_cells

#: Up to this share of the cells of a map is hidden.
MOST_HIDDEN = 0.3


def as_seen(
    samples: Samples, resolution: float, noise: float, holes: float, shift: float, seed: tuple[int, ...]
) -> Samples:
    """The samples as a robot sees them: some maps, drawn at random, through a camera, and all at another height.

    A network learns from them to keep away from what noise and holes may hide: labels are those of the true ground, but
    for hidden cells, which have none. The same for the same seed: a resumed training sees what it would have seen.

    resolution: side of a cell, in [m]. noise: share of the maps that are one image of a drifting depth camera.
    holes: share of the maps that have up to MOST_HIDDEN of their cells hidden.
    shift: standard deviation of how much too high all cells of a map are together, in [m].
    """
    rng = np.random.default_rng(seed)
    heights = samples.heights()
    noisy, holed = rng.random((2, len(samples))) < np.array([[noise], [holes]])
    for index in np.flatnonzero(noisy | holed):
        if noisy[index]:
            heights[index] = depth_camera_reading(heights[index], resolution, rng)
            heights[index] += drift(heights.shape[1], resolution, rng)
        if holed[index]:
            heights[index] = lose_cells(heights[index], rng.uniform(0, MOST_HIDDEN), rng)
    heights += rng.normal(0, shift, (len(samples), 1, 1)).astype(np.float32)
    return with_heights(samples, heights)
