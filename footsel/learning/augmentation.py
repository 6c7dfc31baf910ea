"""What a depth camera would do to the maps that a network learns from; the labels stay those of the true ground."""

import numpy as np

from footsel.dataset.samples import Samples
from footsel.learning.degraded import with_heights
from footsel.terrain.degradation import depth_camera_reading, drift, lose_cells

#: Up to this share of the cells of a map that is seen by the camera is hidden from it.
MOST_HIDDEN = 0.3


def as_seen(samples: Samples, resolution: float, share: float, seed: tuple[int, ...]) -> Samples:
    """The samples with a `share` of their maps, drawn at random, as one image of a drifting depth camera gives them.

    A network learns from them to keep away from what noise and holes may hide: labels are those of the true ground, but
    for hidden cells, which have none. The same for the same seed: a resumed training sees what it would have seen.

    resolution: side of a cell, in [m].
    """
    rng = np.random.default_rng(seed)
    heights = samples.heights()
    for index in np.flatnonzero(rng.random(len(samples)) < share):
        seen = depth_camera_reading(heights[index], resolution, rng) + drift(heights.shape[1], resolution, rng)
        heights[index] = lose_cells(seen, rng.uniform(0, MOST_HIDDEN), rng)
    return with_heights(samples, heights)
