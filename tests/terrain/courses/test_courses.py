import numpy as np
import pytest

from footsel.errors import InputError, UnknownNameError
from footsel.terrain.courses import FAMILIES, make_course, training_map

SEEDS = range(6)
UNEVEN = [family for family in FAMILIES if family != "flat"]


def jumps(elevation):
    """Height differences of neighbouring cells along both axes."""
    return np.concatenate([np.diff(elevation, axis=0).ravel(), np.diff(elevation, axis=1).ravel()])


def steepness(course):
    """(nx - 1, ny - 1) slope in [m/m]."""
    z, d = course.elevation.astype(float), course.resolution
    return np.hypot(np.diff(z, axis=0)[:, :-1] / d, np.diff(z, axis=1)[:-1] / d)


def above_surroundings(course):
    """Height over the median of the 1.2 m tile around a cell: what stands out of the ground or is sunk in it."""
    z = course.elevation.reshape(5, 60, 5, 60)
    return (z - np.median(z, axis=(1, 3), keepdims=True)).reshape(300, 300)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_seed_means_one_course(family):
    course = make_course(family, 5)
    assert course.shape == (300, 300)
    assert np.isfinite(course.elevation).all()
    np.testing.assert_array_equal(course.elevation, make_course(family, 5).elevation)
    np.testing.assert_array_equal(course.elevation, make_course(family, np.random.default_rng(5)).elevation)


@pytest.mark.parametrize("family", UNEVEN)
def test_seeds_differ_in_layout(family):
    courses = [make_course(family, seed).elevation.ravel() for seed in SEEDS]
    for number, course in enumerate(courses):
        for other in courses[:number]:
            assert np.abs(course - other).mean() > 0.005


@pytest.mark.parametrize("family", FAMILIES)
def test_ground_is_near_the_origin(family):
    for seed in SEEDS:
        assert abs(np.median(make_course(family, seed).elevation)) < (0.85 if family == "stones" else 0.3)


@pytest.mark.parametrize("family", UNEVEN)
def test_a_window_of_a_local_map_usually_sees_the_feature(family):
    seen = []
    for seed in range(12):
        z = make_course(family, 100 + seed).elevation
        for i, j in np.random.default_rng(seed).integers(0, 260, (10, 2)):
            seen.append(np.ptp(z[i : i + 40, j : j + 40]) > 0.025)
    assert np.mean(seen) > 0.75


@pytest.mark.parametrize("family", FAMILIES)
def test_cell_size_does_not_change_the_course(family):
    fine = make_course(family, 3, size=4, resolution=0.02)
    coarse = make_course(family, 3, size=4, resolution=0.04)
    x, y = np.meshgrid(coarse.x(), coarse.y(), indexing="ij")
    difference = np.abs(fine.sample(np.stack([x, y], axis=-1)) - coarse.elevation)
    assert np.median(difference) < 0.003


def test_flat_is_level():
    assert not make_course("flat", 0).elevation.any()


def test_slopes_are_up_to_30_degrees_without_edges():
    # Cells on a kink mix the slopes of two facets.
    steepest = [np.rad2deg(np.arctan(np.quantile(steepness(make_course("slopes", s)), 0.98))) for s in range(20)]
    assert max(steepest) < 30.5
    assert max(steepest) > 20
    assert np.ptp(steepest) > 5


def test_steps_are_level_between_rises_of_3_to_25_cm():
    for seed in SEEDS:
        course = make_course("steps", seed)
        rises = np.abs(jumps(course.elevation))
        assert (rises < 0.012).mean() > 0.85
        edges = rises[rises > 0.02]
        assert len(edges) > 300
        assert (edges < 0.28).mean() > 0.9
    assert (jumps(course.elevation) > 0.02).any()
    assert (jumps(course.elevation) < -0.02).any()


def test_edges_run_in_every_direction():
    directions = []
    for seed in range(40):
        z = make_course("steps", seed).elevation
        edge = np.abs(np.diff(z, axis=0)).sum(), np.abs(np.diff(z, axis=1)).sum()
        directions.append(np.arctan2(*edge))
    assert min(directions) < np.deg2rad(25)
    assert max(directions) > np.deg2rad(65)


def test_stairs_have_flights_of_rises_of_8_to_20_cm_up_and_down():
    for seed in SEEDS:
        course = make_course("stairs", seed)
        rises = jumps(course.elevation)
        edges = np.abs(rises[np.abs(rises) > 1e-4])
        assert ((edges > 0.079) & (edges < 0.201)).mean() > 0.6
        assert (rises > 0.07).any()
        assert (rises < -0.07).any()
        assert len(np.unique(np.round(course.elevation, 4))) > 12


def test_gaps_are_deep_and_leave_ground_between():
    for seed in SEEDS:
        depth = -above_surroundings(make_course("gaps", seed))
        assert 0.03 < (depth > 0.2).mean() < 0.5
        assert depth.max() < 1.1


def test_stones_stand_in_deep_water_between_banks():
    for seed in SEEDS:
        course = make_course("stones", seed)
        z = course.elevation
        standing, water = np.abs(z) < 0.13, z < -0.3
        assert (standing | water).all()
        stream = standing[120:180, 120:180]
        assert 0.1 < stream.mean() < 0.75
        # A gap between two stones is stepped over: nowhere is the next stone out of reach, even where one is missing.
        dry = np.argwhere(standing)
        for point in np.argwhere(water[100:200, 100:200])[::97] + 100:
            assert np.linalg.norm(dry - point, axis=1).min() * course.resolution < 0.5
        assert (np.r_[z[0], z[-1], z[:, 0], z[:, -1]] == 0).any()


def test_pillars_and_walls_are_tall_and_thin():
    for seed in SEEDS:
        tall = above_surroundings(make_course("pillars", seed)) > 0.15
        assert 0.01 < tall.mean() < 0.25
        # No 30 cm square is all obstacle: a leg stands beside them.
        sums = np.lib.stride_tricks.sliding_window_view(tall, (15, 15)).sum(axis=(2, 3))
        assert (sums == 225).mean() < 0.002


@pytest.mark.parametrize("family", ["blocks", "rubble"])
def test_blocks_and_rubble_stand_out_of_the_ground(family):
    for seed in SEEDS:
        standing = above_surroundings(make_course(family, seed))
        assert (np.abs(standing) > 0.03).mean() > 0.1
        assert standing.max() < 0.75
        assert (np.abs(jumps(make_course(family, seed).elevation)) > 0.02).mean() > 0.01


def test_rough_ground_is_uneven_everywhere_and_has_no_edges():
    roughness = []
    for seed in range(20):
        z = make_course("rough", seed).elevation
        roughness.append(z.std())
        assert np.abs(z).max() <= 0.14 + 1e-6
        assert np.abs(jumps(z)).max() < 0.09
        # Band-limited: neighbours 2 cm apart belong to the same bump.
        assert np.diff(z, axis=0).std() < 0.7 * z.std()
    assert min(roughness) < 0.02 < max(roughness)


def test_bumps_rise_and_sink():
    for seed in SEEDS:
        relief = above_surroundings(make_course("bumps", seed))
        assert (relief > 0.04).mean() > 0.02
        assert (relief < -0.04).mean() > 0.02


def test_training_map_is_12_m_of_everything():
    terrain = training_map(0)
    assert terrain.size == pytest.approx((12, 12))
    assert np.isfinite(terrain.elevation).all()
    np.testing.assert_array_equal(terrain.elevation, training_map(0).elevation)
    assert np.abs(terrain.elevation - training_map(1).elevation).mean() > 0.01
    slope = steepness(terrain)
    assert 0.1 < (slope < 0.02).mean() < 0.7
    assert (slope > 2).mean() > 0.01
    assert abs(np.median(terrain.elevation)) < 0.05


def test_the_training_map_can_do_without_some_families():
    flat = training_map(0, families=("flat",)).elevation
    assert np.abs(flat).max() < 1e-6
    tame = training_map(0, families=("flat", "rough"))
    # Neither has a cliff; slopes meet others in steep seams.
    assert tame.shape == training_map(0).shape and steepness(tame).max() < 3 < steepness(training_map(0)).max()


def test_seams_of_the_training_map_are_no_cliffs():
    z = training_map(2).elevation
    at_seams = np.concatenate([np.abs(np.diff(z, axis=0))[100 * k - 1] for k in range(1, 6)])
    assert np.median(at_seams) < 0.03


def test_wrong_use_is_told():
    with pytest.raises(UnknownNameError, match=r"lava.*flat, slopes, stairs"):
        make_course("lava", 0)
    with pytest.raises(InputError, match="-1"):
        make_course("flat", -1)
    with pytest.raises(InputError, match="not possible"):
        make_course("flat", 0, size=-2)
    with pytest.raises(InputError, match="not possible"):
        make_course("flat", 0, resolution=0)
