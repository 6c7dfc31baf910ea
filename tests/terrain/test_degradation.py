"""Laws of the camera's noise and of holes."""

import numpy as np
import pytest

from footsel.terrain.degradation import AXIAL, LATERAL, NEAREST, depth_camera_reading, lose_cells, punch_holes

FLAT = np.full((40, 40), -0.45, dtype=np.float32)


def readings(heights, count=300):
    return np.stack([depth_camera_reading(heights, 0.02, np.random.default_rng(seed)) for seed in range(count)])


def test_flat_ground_stays_flat_but_for_the_noise_of_the_depth():
    error = readings(FLAT) - FLAT
    assert abs(error.mean()) < 1e-4
    # At the depths of such a view, 0.3 m to 1.5 m, the depth is good to 0.6 to 5 mm and the height to a part of that.
    low, high = (AXIAL[0] + AXIAL[1] * (z - AXIAL[2]) ** 2 for z in (AXIAL[2], 1.5))
    assert 0.2 * low < error.std(axis=0).min() and error.std(axis=0).max() < high
    # Farther is worse: the map's far rows against its near ones.
    assert error[:, -5:].std() > 1.3 * error[:, :5].std()


@pytest.mark.parametrize("axis", [0, 1])
def test_edges_fray_by_the_lateral_noise(axis):
    step = FLAT.copy()
    step[20:] = -0.30
    step = np.moveaxis(step, 0, axis)
    high = readings(step) > -0.375
    # A cell n cells from the edge is wrong if its reading is off by n cells: depths are 0.5 to 1.2 m here.
    wrong = (high != (step > -0.375)).mean(axis=(0, 2 - axis))
    assert 0.15 < wrong[19] < 0.4 and 0.15 < wrong[20] < 0.4
    assert wrong[19] > 2 * wrong[18] > 4 * wrong[17]
    assert wrong[:14].max() < 1e-3 and LATERAL * 1.2 < 0.02


def test_maps_are_seen_from_near_and_from_far():
    spreads = (readings(FLAT, 60) - FLAT).std(axis=(1, 2))
    assert spreads.max() > 1.5 * spreads.min()


def test_unknown_stays_unknown_and_known_stays_known():
    heights = np.random.default_rng(0).uniform(-0.6, 0.2, (40, 40)).astype(np.float32)
    heights[np.random.default_rng(1).random(heights.shape) < 0.3] = np.nan
    before = heights.copy()
    for found in readings(heights, 5):
        np.testing.assert_array_equal(np.isnan(found), np.isnan(before))
    np.testing.assert_array_equal(heights, before)
    assert NEAREST > 0


@pytest.mark.parametrize("share", [0.0, 0.05, 0.2, 0.7])
def test_as_many_cells_are_lost_as_asked(share):
    heights = np.random.default_rng(0).uniform(-0.6, 0.2, (40, 40)).astype(np.float32)
    clusters = []
    for seed in range(40):
        lost = np.isnan(lose_cells(heights, share, np.random.default_rng(seed)))
        assert lost.sum() == round(share * 1600)
        np.testing.assert_array_equal(lose_cells(heights, share, np.random.default_rng(seed))[~lost], heights[~lost])
        clusters.append((lost[1:] & lost[:-1]).sum() / max(lost.sum(), 1))
    if share == 0.2:  # scattered cells seldom lie side by side, blobs and borders always do
        assert min(clusters) < 0.3 and max(clusters) > 0.8


def test_punched_maps_differ_in_kind_and_share():
    heights = np.zeros((40, 40), dtype=np.float32)
    shares = [np.isnan(punch_holes(heights, np.random.default_rng(seed))).mean() for seed in range(60)]
    assert 0 <= min(shares) < 0.03 and 0.4 < max(shares) < 1
