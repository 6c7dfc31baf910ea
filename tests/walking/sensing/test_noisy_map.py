"""A noisy map differs from the true one as a sensor's does."""

import numpy as np
import pytest

from footsel.terrain import ElevationMap
from footsel.walking.courses.registry import make_walk_course
from footsel.walking.sensing import noisy_map

FLAT = ElevationMap(np.zeros((310, 130)), 0.02, np.array([2.0, 0.5]))


def test_a_flat_map_gets_noise_holes_and_a_drift():
    maps = [noisy_map(FLAT, np.random.default_rng(seed)) for seed in range(20)]
    for each in maps:
        assert each.shape == FLAT.shape and (each.position == FLAT.position).all()
        assert 0.04 < 1 - each.known.mean() < 0.16
        # Neighbours have the same drift: what differs is noise of the depth.
        step = np.diff(each.elevation, axis=1) / np.sqrt(2)
        assert 5e-4 < np.nanstd(step) < 5e-3
        # Far cells differ by the drift as well.
        assert np.nanstd(each.elevation) > 1.1 * np.nanstd(step)
    # A local map is lifted by 3 mm and tilted by 5 mm per metre or so.
    lifts = [np.nanmean(each.elevation[35:45, 35:45]) for each in maps]
    assert 1.5e-3 < np.std(lifts) < 5e-3 and abs(np.mean(lifts)) < 2e-3


def test_what_is_unknown_stays_unknown_and_nothing_else_is_touched():
    heights = np.random.default_rng(0).normal(0, 0.02, (97, 61)).astype(np.float32)
    heights[20:50, 10:40] = np.nan
    true, before = ElevationMap(heights, 0.02), heights.copy()
    degraded = noisy_map(true, np.random.default_rng(1))
    assert np.array_equal(true.elevation, before, equal_nan=True)
    assert not degraded.known[20:50, 10:40].any()
    assert not noisy_map(ElevationMap(np.full((50, 50), np.nan), 0.02), np.random.default_rng(0)).known.any()


@pytest.mark.parametrize("name", ["stairs", "stones"])
def test_a_course_is_recognised(name):
    course = make_walk_course(name, 0)
    degraded = noisy_map(course.ground, np.random.default_rng(0))
    error = np.abs(degraded.elevation - course.ground.elevation)[degraded.known]
    assert np.median(error) < 0.015
    # Edges fray by a cell or two.
    assert (error > 0.05).mean() < 0.3


def test_the_seed_decides():
    one, same, other = (noisy_map(FLAT, np.random.default_rng(seed)).elevation for seed in (1, 1, 2))
    assert np.array_equal(one, same, equal_nan=True)
    assert not np.array_equal(one, other, equal_nan=True)
