"""Lines across maps that others made: supported, level where the robot starts and ends, holes kept."""

from pathlib import Path

import numpy as np
import pytest

from footsel.errors import InputError, MapError
from footsel.terrain import ElevationMap
from footsel.walking.courses import course_across, make_walk_course

SHARED = Path(__file__).parents[4] / "shared" / "maps"
WALKED = ("real_ihmc_cinderblock_field.npz", "mesh_hpp_rubbles_stairs_1.npz")


@pytest.fixture
def causeway():
    """A causeway 1.2 m wide and 4 m long amid unknown ground, that rises by 0.1 m at its middle; a hole on it."""
    elevation = np.full((200, 150), np.nan, dtype=np.float32)
    elevation[:100, 45:105], elevation[100:, 45:105] = 0.3, 0.4
    elevation[60:63, 70:73] = np.nan
    return ElevationMap(elevation, 0.02, np.array([3.0, -1.0]))


def across(elevation_map, seed, **places):
    return course_across("map", elevation_map, np.random.default_rng(seed), **places)


def direction(course):
    return np.array([np.cos(course.start[2]), np.sin(course.start[2])])


def test_the_line_follows_the_causeway(causeway):
    ways = set()
    for seed in range(6):
        course = across(causeway, seed)
        ahead = direction(course)
        np.testing.assert_allclose(np.subtract(course.goal, course.start[:2]) @ [-ahead[1], ahead[0]], 0, atol=1e-9)
        assert 4.8 < np.hypot(*np.subtract(course.goal, course.start[:2])) < 5.3
        # Both feet stay on 1.2 m of ground.
        for along in np.linspace(0.6, 4.4, 30):
            middle = np.array(course.start[:2]) + along * ahead
            for side in (-0.25, 0.25):
                assert abs((middle + side * np.array([-ahead[1], ahead[0]]))[1] + 1.0) < 0.66
        ways.add((ahead[0] > 0, round(course.start[1], 3)))
    assert len(ways) == 6
    assert {forward for forward, _ in ways} == {True, False}


def test_aprons_are_as_high_as_the_edges(causeway):
    course = across(causeway, 1)
    ahead = direction(course)
    low, high = sorted([course.known.sample(course.start[:2]), course.known.sample(course.goal)])
    assert (low, high) == (np.float32(0.3), np.float32(0.4))
    left = np.array([-ahead[1], ahead[0]])
    for place, reach in ((np.array(course.start[:2]), (-1.1, 0.4)), (np.array(course.goal), (-0.4, 0.9))):
        points = place + np.stack(np.meshgrid(np.linspace(*reach, 20), np.linspace(-0.9, 0.9, 20)), -1) @ [ahead, left]
        heights = course.known.sample(points)
        assert np.isfinite(heights).all() and np.ptp(heights) < 1e-6


def test_holes_are_filled_for_physics_alone(causeway):
    course = across(causeway, 0)
    known, ground = course.known.elevation, course.ground.elevation
    assert np.isfinite(ground).all()
    assert np.isnan(known).any()
    seen = ~np.isnan(known)
    np.testing.assert_array_equal(ground[seen], known[seen])
    # Cells of the map stay where they were, the hole among them; nothing is invented in it.
    hole = course.known.sample(causeway.position + (np.array([61, 71]) - [99.5, 74.5]) * 0.02)
    assert np.isnan(hole)
    assert set(np.unique(ground)) == {np.float32(0.3), np.float32(0.4)}
    offset = (course.known.position - causeway.position) / 0.02 + (np.array(causeway.shape) - course.known.shape) / 2
    np.testing.assert_allclose(offset, np.rint(offset), atol=1e-6)


def test_start_and_goal_may_be_given(causeway):
    course = across(causeway, 0, start=(1.5, -1.0), goal=(4.5, -0.8))
    assert course.start == pytest.approx((1.5, -1.0, np.arctan2(0.2, 3.0)))
    assert course.goal == (4.5, -0.8)
    assert course.known is causeway
    with pytest.raises(InputError, match="off the map"):
        across(causeway, 0, start=(1.5, -1.0), goal=(9.0, 0.0))


def test_a_map_that_nothing_crosses_is_refused():
    islands = np.full((100, 100), np.nan, dtype=np.float32)
    islands[::25, ::25] = 0
    with pytest.raises(MapError, match="no line across"):
        across(ElevationMap(islands, 0.02), 0)


def test_a_longer_detour_is_not_taken_over_a_wall():
    """Of two halves side by side, one with a wall of half a metre, the other is walked."""
    elevation = np.zeros((150, 150), dtype=np.float32)
    elevation[70:80, :80] = 0.5
    for seed in range(5):
        course = across(ElevationMap(elevation, 0.02), seed)
        ahead = direction(course)
        if abs(ahead[0]) > 0.9:
            assert course.start[1] > 0.2


def test_both_sides_are_of_about_one_height():
    """On a terrace 1 m wide beside a drop of 0.3 m, the line stays away from the edge, gaps on the terrace or not."""
    elevation = np.zeros((200, 100), dtype=np.float32)
    elevation[:, :50] = 0.3
    elevation[20::25, :] = np.nan
    for seed in range(5):
        course = across(ElevationMap(elevation, 0.02), seed)
        ahead = direction(course)
        assert abs(ahead[0]) > 0.9
        for along in np.linspace(0.7, 4.4, 20):
            assert abs((np.array(course.start[:2]) + along * ahead)[1]) > 0.14


@pytest.mark.parametrize("name", WALKED)
def test_scanned_maps_are_crossed_from_side_to_side(name):
    path = SHARED / name
    if not path.exists():
        pytest.skip("the maps made by others are not here")
    size = ElevationMap.load(path).size
    lines = set()
    for seed in range(4):
        course = make_walk_course(str(path), seed)
        assert np.hypot(*np.subtract(course.goal, course.start[:2])) > 0.9 * max(size) + 0.9
        assert np.isfinite(course.ground.elevation).all()
        again = make_walk_course(str(path), seed)
        assert again.start == course.start and again.goal == course.goal
        lines.add(course.start)
    assert len(lines) == 4
