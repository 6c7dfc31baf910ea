"""Poses of a step: balanced, in reach, and with every limb clear of the ground where it can be."""

import numpy as np
import pytest

from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.terrain import ElevationMap
from footsel.walking.control.base_pose import LONGEST_LEG
from footsel.walking.control.leg_length import LegLength
from footsel.walking.control.limb_clearance import LimbClearance
from footsel.walking.gait.poses import LEAST_MARGIN, STANCE_ADVANCE, Situation, StepPoses, flaw
from footsel.walking.gait.stance import HEIGHT, places
from footsel.walking.gait.swing import plan_swing

ROBOT = load_robot("anymal_b")
RADIUS = ROBOT.description.foot_radius
FEET = np.column_stack([places(), np.full(4, RADIUS)])
BASE, COM = BasePose(0.0, 0.0, HEIGHT), np.array([0.0, 0.0, 0.02])


def ground(change=None):
    heights = np.zeros((151, 101), dtype=np.float32)
    if change is not None:
        change(heights, (np.arange(151) - 75) * 0.02)
    return ElevationMap(heights, 0.02)


def stairs(heights, x):
    """15 cm every 30 cm, the first riser a little ahead of the hind feet."""
    heights += 0.15 * np.clip(np.ceil((x + 0.25) / 0.30), 0, None)[:, None]


def on(elevation_map, xy):
    return np.array([*xy, float(elevation_map.sample(np.array(xy))) + RADIUS])


@pytest.fixture
def climbing():
    """Fore feet two steps above the hind ones, which stand before the first riser."""
    elevation_map = ground(stairs)
    feet = np.array([on(elevation_map, xy) for xy in ((0.42, 0.245), (0.45, -0.245), (-0.36, 0.245), (-0.36, -0.245))])
    return Situation(elevation_map, feet, BasePose(0.0, 0.0, 0.62, 0.0, -0.3), COM)


def test_on_level_ground_the_base_is_where_its_feet_want_it():
    now, poses = Situation(ground(), FEET, BASE, COM), StepPoses(ROBOT, 0.0)
    answer = poses.at_touchdown(now, "LH", FEET[2], "LF", 0.0)
    assert not flaw(answer) and answer.margin > LEAST_MARGIN
    assert answer.pose.z == pytest.approx(HEIGHT, abs=0.02) and abs(answer.pose.pitch) < 0.02
    lower = poses.at_touchdown(now, "LH", FEET[2], "LF", 0.06)
    assert answer.pose.z - lower.pose.z == pytest.approx(0.06, abs=0.01)


def test_limbs_are_clear_at_touchdown_though_the_base_has_to_rise_for_them(climbing):
    poses, target = StepPoses(ROBOT, 0.0), on(climbing.elevation_map, (-0.1, 0.245))
    answer = poses.at_touchdown(climbing, "LH", target, "LF", 0.15)
    assert not flaw(answer) and answer.clearance > -0.01
    # On ground that the map does not know, nothing is in the way: the base stays lower.
    blind = Situation(
        ground(lambda heights, x: heights.__setitem__(slice(None), np.nan)), climbing.feet, climbing.base, COM
    )
    unaware = poses.at_touchdown(blind, "LH", target, "LF", 0.15)
    landed = climbing.feet.copy()
    landed[2] = target
    found = LimbClearance(ROBOT).at(climbing.elevation_map, unaware.pose, landed).worst
    assert found < answer.clearance and unaware.clearance == np.inf


def test_a_lift_is_as_clear_as_it_says(climbing):
    """Along the motion that the base is to make, and no better than at the pose itself."""
    poses, target = StepPoses(ROBOT, 0.0), on(climbing.elevation_map, (-0.1, 0.245))
    touchdown = poses.at_touchdown(climbing, "LH", target, "LF", 0.0).pose
    swing = plan_swing(climbing.elevation_map, 1.0, climbing.feet[2], target, RADIUS)
    lift = poses.at_lift(climbing, "LH", touchdown, swing)
    limbs, motion = LimbClearance(ROBOT), lift.motion_to(touchdown, swing)
    np.testing.assert_allclose(motion.at(swing.start)[0], lift.answer.pose.as_list(), atol=1e-9)
    np.testing.assert_allclose(motion.at(swing.end)[0], touchdown.as_list(), atol=1e-9)
    assert not lift.speed(touchdown, swing)[2:].any()
    for time in np.linspace(swing.start, swing.end, 50).tolist():
        feet = climbing.feet.copy()
        feet[2] = swing.at(time)[0]
        values = motion.at(time)[0].tolist()
        assert limbs.at(climbing.elevation_map, BasePose(*values), feet).worst > lift.clearance - 0.015


def test_a_foothold_that_a_riser_will_be_too_near_to_lacks_more():
    """A hind knee moves ahead over the next step while its foot stands: better not just before a riser that is high."""
    wall = ground(lambda heights, x: heights.__setitem__(x > 0.05, 0.35))
    now, poses = Situation(wall, FEET, BASE, COM), StepPoses(ROBOT, 0.0)
    targets = np.array([[-0.36, 0.245, RADIUS], [-0.1, 0.245, RADIUS]])
    lacks = poses.lack_at_end_of_stance(now, "LH", BasePose(-0.02, 0.0, HEIGHT), targets)
    assert lacks[0] < 0.01 and lacks[1] > 0.05


def test_a_foothold_that_the_base_will_leave_behind_lacks_length():
    now, poses = Situation(ground(), FEET, BASE, COM), StepPoses(ROBOT, 0.0)
    targets = np.array([[-0.25, 0.245, RADIUS], [-0.75, 0.245, RADIUS]])
    lacks = poses.lack_at_end_of_stance(now, "LH", BASE, targets)
    legs = LegLength(ROBOT)
    hip = BASE.position + legs.hips[LEGS.index("LH")] + [STANCE_ADVANCE, 0.0, 0.0]
    assert lacks[0] == 0 and lacks[1] == pytest.approx(float(legs.between(hip, targets[1])) - LONGEST_LEG, abs=5e-3)
