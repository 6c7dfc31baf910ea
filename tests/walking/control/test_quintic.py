"""Smooth motions meet their ends."""

import numpy as np

from footsel.walking.control.quintic import Quintic


def test_it_begins_and_ends_as_told_and_its_rates_are_its_own():
    rng = np.random.default_rng(0)
    first, last, speed = rng.normal(size=(3, 2)), rng.normal(size=2), rng.normal(size=2)
    motion = Quintic.between(3.0, 0.7, tuple(first), last, speed)
    np.testing.assert_allclose(motion.at(3.0), first)
    np.testing.assert_allclose(motion.at(motion.end)[0], last)
    np.testing.assert_allclose(motion.at(motion.end)[1], speed, atol=1e-9)
    np.testing.assert_allclose(motion.at(motion.end)[2], 0, atol=1e-9)
    for time in (3.1, 3.35, 3.6):
        before, now, after = (motion.at(time + shift) for shift in (-1e-5, 0, 1e-5))
        np.testing.assert_allclose((after[0] - before[0]) / 2e-5, now[1], atol=1e-6)
        np.testing.assert_allclose((after[1] - before[1]) / 2e-5, now[2], atol=1e-5)


def test_beyond_its_end_it_goes_on():
    motion = Quintic.between(0.0, 1.0, ([0.0], [0.0], [0.0]), [1.0], [-0.2])
    position, velocity, acceleration = motion.at(1.5)
    np.testing.assert_allclose([position[0], velocity[0], acceleration[0]], [0.9, -0.2, 0.0])
