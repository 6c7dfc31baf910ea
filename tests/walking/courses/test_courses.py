"""Built-in courses: bounds, lengths, heights and gaps as their names promise, and a layout of its own for each seed."""

import numpy as np
import pytest
from scipy import ndimage

from footsel.errors import InputError, UnknownNameError
from footsel.walking.courses import WALK_COURSES, make_walk_course

SEEDS = range(8)
UNEVEN = [name for name in WALK_COURSES if name != "flat"]
RISE = {"stairs12": 0.12, "stairs": 0.15, "stairs17": 0.17}
STONES = {"stones": (0.16, 0.25, 0.15), "stones_hard": (0.12, 0.25, 0.25)}


def profile(course, y=0.0):
    """x and heights of the row of cells nearest to the line at `y`."""
    column = np.abs(course.ground.y() - y).argmin()
    return course.ground.x(), course.ground.elevation[:, column].astype(float)


def between_aprons(course):
    """(k, ny) heights between the start's and the goal's apron."""
    x = course.ground.x()
    return course.ground.elevation[(x > 0.5) & (x < course.goal[0] - 0.4)].astype(float)


@pytest.mark.parametrize("name", WALK_COURSES)
def test_a_flat_apron_an_obstacle_and_another_flat_apron(name):
    for seed in SEEDS:
        course = make_walk_course(name, seed)
        assert course.name == name and course.known is course.ground
        assert course.start == (0.0, 0.0, 0.0) and course.goal[1] == 0.0
        x, z = course.ground.x(), course.ground.elevation
        assert np.isfinite(z).all()
        assert course.ground.resolution == 0.02
        assert x[0] < -1 and x[-1] > course.goal[0] + 0.8
        assert course.ground.y()[0] < -1.2 and course.ground.y()[-1] > 1.2
        # Where the robot stands, at both ends, the ground is level.
        feet = np.abs(course.ground.y()) < 0.3
        assert not z[x < 0.45][:, feet].any()
        assert np.ptp(z[x > course.goal[0] - 0.4][:, feet]) == 0
        if name != "flat":
            uneven = x[(np.abs(z - z[0]) > 0.004).any(axis=1) & (np.abs(z - z[-1]) > 0.004).any(axis=1)]
            assert np.ptp(uneven) > (2.0 if name in ("slopes", "gaps", *RISE) else 2.4)
        assert course.goal[0] - 1.15 >= 2.49


@pytest.mark.parametrize("name", WALK_COURSES)
def test_a_seed_means_one_course(name):
    first, again = make_walk_course(name, 5), make_walk_course(name, 5)
    np.testing.assert_array_equal(first.ground.elevation, again.ground.elevation)
    np.testing.assert_array_equal(first.ground.position, again.ground.position)
    assert first.goal == again.goal


@pytest.mark.parametrize("name", UNEVEN)
def test_seeds_differ_in_layout_and_not_by_a_shift(name):
    courses = [make_walk_course(name, seed).ground for seed in SEEDS]
    for number, course in enumerate(courses):
        for other in courses[:number]:
            x, y = np.meshgrid(np.arange(0.2, 3.5, 0.04), np.arange(-0.8, 0.81, 0.04), indexing="ij")
            points = np.stack([x, y], axis=-1)
            nearest = min(
                np.abs(course.sample(points) - other.sample(points + np.array([dx, dy]))).mean()
                for dx in np.arange(-0.4, 0.41, 0.1)
                for dy in (-0.3, -0.15, 0, 0.15, 0.3)
            )
            # Stairs with risers of 12 cm and treads alike are the most alike.
            assert nearest > 0.008


@pytest.mark.parametrize("name", RISE)
@pytest.mark.parametrize("y", [-0.4, 0.0, 0.4])
def test_stairs_go_up_and_down_on_at_least_five_risers_each(name, y):
    counts = set()
    for seed in SEEDS:
        x, z = profile(make_walk_course(name, seed), y)
        rises = np.diff(z)
        up, down = np.flatnonzero(rises > 0.01), np.flatnonzero(rises < -0.01)
        assert len(up) >= 5 and len(down) >= 5 and up.max() < down.min()
        np.testing.assert_allclose(np.abs(rises[[*up, *down]]), RISE[name], atol=0.0031)
        treads = np.concatenate([np.diff(x[up]), np.diff(x[down])])
        assert treads.min() > 0.24 and treads.max() < 0.35
        counts.add((len(up), len(down)))
    assert len(counts) > 2


def test_slopes_are_of_15_to_20_degrees():
    for seed in SEEDS:
        course = make_walk_course("slopes", seed)
        slope = np.rad2deg(np.arctan(np.hypot(*np.gradient(course.ground.elevation.astype(float), 0.02))))
        # Cells on a kink mix two slopes.
        sloping = slope[slope > 0.1]
        assert np.mean((sloping > 14.99) & (sloping < 20.01)) > 0.93
        assert sloping.max() < 20.1


def test_rough_ground_is_equally_rough_and_has_no_edges():
    for seed in SEEDS:
        z = between_aprons(make_walk_course("rough", seed))
        assert 0.02 < z[20:-20].std() < 0.05
        assert np.abs(z).max() <= 0.14 + 1e-6
        assert np.abs(np.diff(z, axis=0)).max() < 0.09


def test_blocks_are_dense_and_up_to_18_cm():
    highest = []
    for seed in SEEDS:
        z = between_aprons(make_walk_course("blocks", seed))
        highest.append(z.max())
        assert z.min() > -1e-6
        assert (z[20:-20] > 0.03).mean() > 0.5
        edges = np.abs(np.diff(z, axis=0)) > 0.04
        assert edges.mean() > 0.02
    assert 0.16 < max(highest) <= 0.18 + 1e-6


def test_rubble_is_dense_and_slanted():
    for seed in SEEDS:
        z = between_aprons(make_walk_course("rubble", seed))
        inner = z[20:-20]
        assert (inner > 0.02).mean() > 0.45
        assert 0.12 < z.max() < 0.32
        slope = np.hypot(*np.gradient(inner, 0.02))
        assert np.median(slope[inner > 0.02]) > np.tan(np.deg2rad(5))


@pytest.mark.parametrize("name", STONES)
def test_stones_stand_in_deep_water_between_banks(name):
    narrowest, widest, _ = STONES[name]
    for seed in SEEDS:
        course = make_walk_course(name, seed)
        z = course.ground.elevation.astype(float)
        dry = z > -0.2
        assert np.abs(z[dry]).max() <= 0.05 + 1e-6
        assert z[~dry].max() < -0.46 and z[~dry].min() > -0.56
        pieces, count = ndimage.label(dry)
        stream = between_aprons(course) > -0.2
        assert 0.2 < stream.mean() < 0.7

        # Widths over all directions, of stones that are whole.
        border = set(np.unique(np.concatenate([pieces[0], pieces[-1], pieces[:, 0], pieces[:, -1]])))
        angles = np.deg2rad(np.arange(0, 180, 5))
        for piece in set(range(1, count + 1)) - border:
            points = np.argwhere(pieces == piece) * 0.02
            widths = np.ptp(points @ np.array([np.cos(angles), np.sin(angles)]), axis=0)
            assert widths.min() > narrowest - 0.045  # Of cell centres: up to two cells less.
            assert widths.max() < np.sqrt(2) * widest
        assert count > 40


@pytest.mark.parametrize("name", STONES)
def test_gaps_between_stones_are_no_wider_than_said(name):
    gap = STONES[name][2]
    widest = []
    for seed in SEEDS:
        dry = make_walk_course(name, seed).ground.elevation > -0.2
        pieces, _ = ndimage.label(dry)
        first, last = pieces[0, 0], pieces[-1, 0]
        # Step by step over gaps that are allowed, a cell's rounding included, the other bank is reached.
        reached, before = pieces == first, 0
        while reached.sum() > before:
            before = reached.sum()
            near = ndimage.distance_transform_edt(~reached) * 0.02 <= gap + 0.04
            reached = np.isin(pieces, np.unique(pieces[near & dry]))
        assert (pieces[reached] == last).any()
        # None stands alone: all of the stones are reached.
        assert reached.sum() == dry.sum()
        columns = np.flatnonzero(np.abs(make_walk_course(name, seed).ground.y()) < 0.6)
        runs = ndimage.distance_transform_edt(~dry)[:, columns].max() * 2 * 0.02
        widest.append(runs)
    assert max(widest) > gap


def test_gaps_are_trenches_of_10_to_25_cm():
    for seed in SEEDS:
        _, z = profile(make_walk_course("gaps", seed))
        deep = z < -0.35
        assert z.min() >= -0.6 and not z[~deep].any()
        starts, ends = np.flatnonzero(np.diff(deep.astype(int)) == 1), np.flatnonzero(np.diff(deep.astype(int)) == -1)
        assert len(starts) >= 4
        widths = (ends - starts) * 0.02
        # A winding or slanting trench is longer along the line.
        assert widths.min() > 0.07 and widths.max() < 0.31
        assert ((starts[1:] - ends[:-1]) * 0.02).min() > 0.2


def test_wrong_use_is_told():
    with pytest.raises(
        UnknownNameError, match=r"unknown terrain 'lava'.*flat, slopes, stairs12.*an elevation map's file"
    ):
        make_walk_course("lava", 0)
    with pytest.raises(InputError, match="-1"):
        make_walk_course("flat", -1)
    with pytest.raises(InputError, match=r"lava\.npz: no such file"):
        make_walk_course("lava.npz", 0)
