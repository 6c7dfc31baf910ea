"""When the head is lowered, and how far."""

import numpy as np
import pytest

from footsel.footholds import BasePose
from footsel.robot import load_robot
from footsel.selectors import make_selector
from footsel.terrain import ElevationMap
from footsel.walking.courses.registry import make_walk_course
from footsel.walking.gait.line import Line
from footsel.walking.gait.look import AHEAD, BEGIN, ELSEWHERE, LEVELS, SHIFT, Lookout, hidden_ground
from footsel.walking.gait.poses import Situation, flaw
from footsel.walking.gait.stance import places
from footsel.walking.map_source import GivenMap, MapSource
from footsel.walking.observer import WalkObserver
from footsel.walking.sensing import CameraMap
from footsel.walking.walk import walk

ROBOT = load_robot("anymal_b")
RADIUS = ROBOT.description.foot_radius
LINE = Line(np.zeros(2), 0.0, 3.0)
FEET = np.column_stack([places(), np.full(4, RADIUS)])
COM = np.array([0.0, 0.0, 0.02])


def ground(begin=0.0, end=0.0, depth=0.0):
    """Level ground, lower from `begin` on, and unknown from there to `end`."""
    x = (np.arange(201) - 100) * 0.02
    heights = np.zeros((201, 151), dtype=np.float32)
    heights[x > begin + 1e-6] -= depth
    heights[(x > begin + 1e-6) & (x < end)] = np.nan
    return ElevationMap(heights, 0.02)


def at(elevation_map, x=0.0):
    return Situation(elevation_map, FEET + np.array([x, 0, 0]), BasePose(x, 0.0, 0.45), COM)


@pytest.mark.parametrize("yaw", [0.0, 0.5])
def test_hidden_ground_is_the_unknown_ground_that_feet_may_stand_on(yaw):
    base = BasePose(0.0, 0.0, 0.45, yaw=yaw)
    assert hidden_ground(ground(), base, 0.0) == (np.inf, 0.0)
    begin, area = hidden_ground(ground(0.5, 0.66, 0.15), base, 0.0)
    if yaw == 0.0:
        assert begin == pytest.approx(0.54, abs=0.03) and area == pytest.approx(0.16 * 0.7, rel=0.15)
    else:
        assert area > 0.02
    # Not what lies deeper than legs reach, behind the fore feet or far ahead.
    for elsewhere in (ground(0.5, 0.66, LEVELS + 0.05), ground(0.0, 0.3), ground(AHEAD[1] + 0.05, 1.5)):
        assert hidden_ground(elsewhere, BasePose(0.0, 0.0, 0.45), 0.0)[1] == 0.0


def test_it_looks_once_from_a_place_and_only_at_what_is_hidden():
    lookout = Lookout(ROBOT, LINE)
    edge = ground(0.5, 0.66, 0.15)
    assert lookout.pose(at(ground()), stuck=False) is None
    pose = lookout.pose(at(edge), stuck=False)
    assert pose is not None and pose.pitch > 0.2 and abs(pose.x) < SHIFT + 0.05
    assert not flaw(lookout._poses.head_down(at(edge), pose.pitch, 0.0))
    assert lookout.pose(at(edge, 0.5 * ELSEWHERE), stuck=False) is None
    assert lookout.pose(at(edge, 0.5 * ELSEWHERE), stuck=True) is None
    assert lookout.pose(at(edge, 1.1 * ELSEWHERE), stuck=False) is not None
    assert lookout.pose(at(ground(), 3 * ELSEWHERE), stuck=True) is not None


def test_the_base_goes_ahead_for_what_begins_further_on():
    near, far = (
        Lookout(ROBOT, LINE).pose(at(ground(begin, begin + 0.16, 0.15)), stuck=False) for begin in (0.42, 0.54)
    )
    assert near is not None and far is not None and far.x > near.x + 0.04
    assert Lookout(ROBOT, LINE).pose(at(ground(BEGIN + SHIFT + 0.02, 1.5, 0.15)), stuck=False) is None


def test_only_maps_that_may_learn_are_looked_for():
    assert CameraMap.learns and not GivenMap(ground()).learns


class Shy(MapSource):
    """Hides a strip ahead until the base looks down on it."""

    def __init__(self, learns, open_at=0.15):
        self.learns, self._open_at, self._seen = learns, open_at, False

    def update(self, time, base, joints):
        """Looks."""
        del time, joints
        self._seen |= -base[2, 0] > np.sin(self._open_at)

    def elevation_map(self):
        return ground() if self._seen else ground(0.5, 0.8)


class Pitches(WalkObserver):
    """Keeps how low the head is."""

    def __init__(self):
        self.pitches = []

    def see(self, moment):
        self.pitches.append(float(np.arcsin(-moment.base[2, 0])))


@pytest.mark.parametrize("learns", [True, False])
def test_a_robot_that_may_learn_looks_down_and_walks_on(learns):
    watch, source = Pitches(), Shy(learns)
    course = make_walk_course("flat", 0)
    result = walk(course, make_selector("nominal"), source, 0, "shy", observers=[watch], time_limit_s=7.0)
    assert source._seen == learns
    assert (max(watch.pitches) > 0.15) == learns
    # The head comes up again, and steps follow.
    assert abs(watch.pitches[-1]) < 0.1 and result.steps >= 2
