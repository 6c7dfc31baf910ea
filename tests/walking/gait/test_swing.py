"""A swinging foot clears what the map says lies between."""

import numpy as np
import pytest

from footsel.terrain import ElevationMap
from footsel.walking.gait.swing import CAUTION, CLEARANCE, LIFT, TOUCHDOWN_SPEED, plan_swing, required_height

RADIUS = 0.031
FOOT, GOAL = np.array([-0.14, 0.0, RADIUS]), np.array([0.14, 0.0, RADIUS])


def ground(change=None):
    """2x2 m of level ground; `change` gets the heights and the x of their rows."""
    heights = np.zeros((101, 101), dtype=np.float32)
    if change is not None:
        change(heights, (np.arange(101) - 50) * 0.02)
    return ElevationMap(heights, 0.02)


def wall(height):
    return lambda heights, x: heights.__setitem__(np.abs(x) < 0.03, height)


def flown(swing, start):
    return np.array([swing.at(time)[0] for time in np.linspace(start, swing.end, 300)])


@pytest.mark.parametrize("height", [0.0, 0.1, 0.2])
def test_it_goes_from_foot_to_goal_over_the_wall(height):
    swing = plan_swing(ground(wall(height)), 2.0, FOOT, GOAL, RADIUS)
    way = flown(swing, 2.0)
    np.testing.assert_allclose(way[0], FOOT, atol=1e-9)
    np.testing.assert_allclose(way[-1], GOAL, atol=1e-6)
    assert swing.at(swing.end)[1][2] == pytest.approx(-TOUCHDOWN_SPEED)
    over = np.abs(way[:, 0]) < 0.03
    assert way[over, 2].min() > height + RADIUS + CLEARANCE - 0.01
    assert way[:, 2].max() > max(height, 0) + LIFT


def test_it_lifts_before_it_moves_where_a_step_is_near():
    """A riser 6 cm before the foot: at the height of its edge the foot is not yet there."""

    def stair(heights, x):
        heights[x > FOOT[0] + 0.07] = 0.15

    goal = GOAL + np.array([0, 0, 0.15])
    way = flown(plan_swing(ground(stair), 0.0, FOOT, goal, RADIUS), 0.0)
    reached = way[:, 0] > FOOT[0] + 0.05
    assert way[reached, 2][0] > 0.15


def test_unknown_ground_is_passed_higher():
    def hole(heights, x):
        heights[np.abs(x) < 0.05] = np.nan

    known, unknown = (required_height(ground(change), FOOT, GOAL, RADIUS).max() for change in (None, hole))
    assert unknown == pytest.approx(known + CAUTION, abs=1e-6)


def test_it_sinks_on_where_the_ground_is_late():
    swing = plan_swing(ground(), 0.0, FOOT, GOAL, RADIUS)
    position, velocity, _ = swing.at(swing.end + 0.2)
    np.testing.assert_allclose(position, [*GOAL[:2], GOAL[2] - 0.2 * TOUCHDOWN_SPEED], atol=1e-6)
    np.testing.assert_allclose(velocity, [0, 0, -TOUCHDOWN_SPEED], atol=1e-9)


def test_it_is_one_motion():
    swing = plan_swing(ground(wall(0.15)), 0.0, FOOT, GOAL, RADIUS)
    way = flown(swing, 0.0)
    assert np.abs(np.diff(way, axis=0)).max() < 0.02
