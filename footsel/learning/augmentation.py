"""What a depth camera would do to the maps that a network learns from; the labels stay those of the true ground."""

from dataclasses import replace

import numpy as np

from footsel.dataset.samples import Samples, encode_heights
from footsel.terrain.degradation import sensor_noise


def with_noise(samples: Samples, resolution: float, times: float, seed: tuple[int, ...]) -> Samples:
    """The samples with noisy heights, the same for the same seed: a resumed training sees what it would have seen.

    resolution: side of a cell, in [m]. times: how many times the noise of the camera.
    """
    rng = np.random.default_rng(seed)
    noise = times * sensor_noise(samples.heights(), resolution, rng)
    return replace(samples, heights_tenth_mm=encode_heights(samples.heights() + noise))
