"""The maps that an export is tried on are the poses of a robot on courses, and the same for the same seed."""

import numpy as np

from footsel.exporting.trial_maps import trial_maps
from footsel.terrain.courses import FAMILIES


def test_trial_maps_cover_what_a_robot_meets(anymal_layout):
    maps = trial_maps(anymal_layout, "LF", 10 * len(FAMILIES), seed=0)
    assert maps.heights.shape == (len(maps), 40, 40)
    unknown = np.isnan(maps.heights).mean(axis=(1, 2))
    assert (unknown == 0).sum() > len(maps) / 4
    assert (unknown > 0).sum() > len(maps) / 10
    level = np.nanmedian(maps.heights[unknown < 1])
    assert -0.55 < level < -0.35
    assert abs(maps.roll).max() <= np.deg2rad(10)
    # Every family has its courses: flat ground spans little, pillars much.
    assert np.nanmax(maps.heights) > 0


def test_trial_maps_are_reproducible(anymal_layout):
    one, same, other = (trial_maps(anymal_layout, "LH", 12, seed) for seed in (4, 4, 5))
    np.testing.assert_array_equal(one.heights, same.heights)
    np.testing.assert_array_equal(one.roll, same.roll)
    assert not np.array_equal(one.heights, other.heights, equal_nan=True)
