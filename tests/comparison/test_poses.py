"""Laws of the base poses that selectors are compared at."""

from dataclasses import replace

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.comparison.poses import REFERENCE_STANDING_HEIGHT, draw_poses
from footsel.errors import MapError
from footsel.robot import load_robot


def heights_above_ground(poses, elevation_map, layout):
    return np.array([pose.z - layout.ground_height(elevation_map, pose.x, pose.y, pose.yaw) for pose in poses])


@pytest.fixture(scope="module")
def layout():
    return load_robot("anymal_b").layout


def test_the_reference_is_anymal_b(layout):
    assert layout.standing_height == pytest.approx(REFERENCE_STANDING_HEIGHT, abs=1e-9)


@pytest.mark.parametrize("index", [0, 1])
def test_poses_stand_on_known_cells_within_the_stated_ranges(maps, layout, index):
    elevation_map = maps[index].elevation_map
    poses = draw_poses(np.random.default_rng(0), elevation_map, layout, 300)
    values = np.array([pose.as_list() for pose in poses])
    cells = np.floor(elevation_map.fractional_index(values[:, :2]) + 0.5).astype(int)
    assert elevation_map.known[tuple(cells.T)].all()
    heights = heights_above_ground(poses, elevation_map, layout)
    assert heights.min() >= 0.38 - 1e-6
    assert heights.max() <= 0.55 + 1e-6
    assert heights.min() < 0.39
    assert heights.max() > 0.54
    tilt = np.abs(values[:, 3:5])
    assert np.deg2rad(9.5) < tilt.max() <= np.deg2rad(10)
    assert np.ptp(values[:, 5]) > 6.1


def test_fewer_poses_are_the_first_of_more(maps, layout):
    few = draw_poses(np.random.default_rng(5), maps[0].elevation_map, layout, 3)
    assert few == draw_poses(np.random.default_rng(5), maps[0].elevation_map, layout, 9)[:3]


def test_a_robot_of_half_the_height_is_drawn_at_half_the_height(maps, layout):
    feet = {leg: foot * np.array([1, 1, 0.5]) for leg, foot in layout.nominal_feet.items()}
    small = replace(layout, nominal_feet=feet)
    elevation_map = maps[0].elevation_map
    here, there = (
        heights_above_ground(draw_poses(np.random.default_rng(1), elevation_map, robot, 20), elevation_map, robot)
        for robot in (layout, small)
    )
    np.testing.assert_allclose(there, here / 2, atol=1e-9)


def test_a_map_without_known_ground_is_refused(layout):
    with pytest.raises(MapError, match="known ground"):
        draw_poses(np.random.default_rng(0), ElevationMap(np.full((50, 50), np.nan), 0.02), layout, 1)
