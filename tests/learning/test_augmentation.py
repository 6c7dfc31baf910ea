"""Noise on training maps: of the size that is asked for, the same for the same seed, never on labels or holes."""

import numpy as np

from footsel.dataset.samples import UNKNOWN_HEIGHT
from footsel.learning.augmentation import with_noise
from footsel.terrain.degradation import AXIAL, DRIFT_HEIGHT, sensor_noise


def test_the_same_seed_gives_the_same_noise(samples):
    one, again, other = (with_noise(samples, 0.02, 1.0, seed) for seed in ((1, 2, 3), (1, 2, 3), (1, 2, 4)))
    assert np.array_equal(one.heights_tenth_mm, again.heights_tenth_mm)
    assert not np.array_equal(one.heights_tenth_mm, other.heights_tenth_mm)


def test_labels_poses_and_holes_stay(samples):
    noisy = with_noise(samples, 0.02, 5.0, (0,))
    known = samples.heights_tenth_mm != UNKNOWN_HEIGHT
    assert np.array_equal(noisy.heights_tenth_mm != UNKNOWN_HEIGHT, known) and not known.all()
    assert (noisy.heights_tenth_mm != samples.heights_tenth_mm)[known].mean() > 0.9
    for name in ("cost", "reason", "pose", "family", "course"):
        assert getattr(noisy, name) is getattr(samples, name)


def test_it_grows_with_the_distance_and_the_factor():
    near, far = np.full((200, 40, 40), -0.35, dtype=np.float32), np.full((200, 40, 40), -1.5, dtype=np.float32)
    floor, growth, nearest = AXIAL
    for heights in (near, far):
        noise = sensor_noise(heights, 0.02, np.random.default_rng(0))
        # Neighbouring cells share the drift, so their difference is noise alone.
        spread = np.std(noise[:, 19, 19] - noise[:, 19, 20]) / np.sqrt(2)
        expected = floor + growth * (abs(float(heights[0, 0, 0])) - nearest) ** 2
        assert 0.85 * expected < spread < 1.15 * expected
    drift = sensor_noise(near, 0.02, np.random.default_rng(0)).mean(axis=(1, 2))
    assert 0.85 * DRIFT_HEIGHT < drift.std() < 1.15 * DRIFT_HEIGHT
