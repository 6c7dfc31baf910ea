"""Poses of a step: balanced, in reach, and with every limb clear of the ground where it can be."""

from dataclasses import replace

import numpy as np
import pytest

from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.terrain import ElevationMap
from footsel.walking.control.base_pose import FOLDED_LEG, LONGEST_LEG, PoseAnswer
from footsel.walking.control.leg_length import LegLength
from footsel.walking.control.limb_clearance import LimbClearance
from footsel.walking.gait import planner
from footsel.walking.gait.poses import LEAST_BALANCE, LEAST_MARGIN, STANCE_ADVANCE, Lift, Situation, StepPoses, flaw
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


@pytest.mark.parametrize("drop", [0.0, 0.3])
def test_a_leg_that_folds_on_its_way_is_noticed(drop):
    """A wall between foot and foothold that the hip is hardly above. With the fore feet far down the head is low, and
    the axis of abduction comes nearer to the swinging foot than the hip does; limbs are nobody's concern here.
    """

    def wall(heights, x):
        heights[x > 0.1] = -drop
        heights[np.abs(x + 0.24) < 0.05] = 0.25 - drop / 2

    map_, feet = ground(wall), FEET - np.outer([drop, drop, 0.0, 0.0], [0.0, 0.0, 1.0])
    now = Situation(map_, feet, BasePose(0.05, 0.0, 0.40 - drop / 2, 0.0, drop), COM)
    poses, legs = StepPoses(ROBOT, 0.0, watch_limbs=False), LegLength(ROBOT)
    target = feet[2] + [0.3, 0.0, 0.0]
    touchdown = poses.at_touchdown(now, "LH", target, "LF", 0.10).pose
    swing = plan_swing(map_, 0.0, feet[2], target, RADIUS)
    lift = poses.at_lift(now, "LH", touchdown, swing)
    motion = lift.motion_to(touchdown, swing)
    for time in np.linspace(swing.start, swing.end, 50).tolist():
        base = BasePose(*motion.at(time)[0].tolist())
        hip = base.position + base.rotation() @ legs.hips[LEGS.index("LH")]
        assert legs.depth(base.rotation(), hip, swing.at(time)[0]) - FOLDED_LEG > lift.clearance - 0.01


def test_a_base_that_has_to_hurry_out_of_its_support_is_out_of_balance():
    """Balance at rest is the margin of the centre of mass; a long way within one swing takes it away."""
    now, poses = Situation(ground(), FEET, BASE, COM), StepPoses(ROBOT, 0.0)
    near = poses.at_touchdown(now, "LH", FEET[2], "LF", 0.0)
    swing = plan_swing(ground(), 0.0, FEET[2], FEET[2] + [0.2, 0.0, 0.0], RADIUS)
    still = poses.at_lift(now, "LH", near.pose, swing)
    assert LEAST_BALANCE < still.balance <= still.answer.margin + 1e-6
    x, y, z, *turn = near.pose.as_list()
    far = BasePose(x + 0.4, y, z, *turn)
    assert poses.at_lift(now, "LH", far, swing).balance < LEAST_BALANCE


@pytest.mark.parametrize(
    ("changed", "words"), [({}, ""), ({"unfolded": -0.03}, "folded"), ({"clearance": -0.06}, "touch")]
)
def test_a_step_whose_leg_folds_on_its_way_is_refused(changed, words):
    """By little already, unlike limbs near the ground: those touch it, this throws the base."""
    fine = Lift(PoseAnswer(BASE, 0.05, 0.0), 1.0, clearance=-0.03, unfolded=0.0, balance=0.02)
    problem = planner._problem(replace(fine, **changed))
    assert words in problem and bool(problem) == bool(words)
