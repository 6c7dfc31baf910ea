"""Steps: on the line, on ground, with a base that can take them; and a plain answer where there is none."""

import numpy as np
import pytest

from footsel.footholds import BasePose, Foothold
from footsel.footholds.foothold import Alternative
from footsel.footholds.pose import tilt_rotation
from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.selectors import make_selector
from footsel.terrain import ElevationMap
from footsel.walking.gait.line import Line
from footsel.walking.gait.planner import LARGEST_LACK, ORDER, STRIDE, NoStep, Step, StepPlanner
from footsel.walking.gait.poses import LEAST_MARGIN, Situation
from footsel.walking.gait.stance import counter_clockwise, places, plane_tilt
from footsel.walking.gait.walker import ground_normal

ROBOT = load_robot("anymal_b")
RADIUS = ROBOT.description.foot_radius
LINE = Line(np.zeros(2), 0.0, 3.0)
FEET = np.column_stack([places(), np.full(4, RADIUS)])
BASE, COM = BasePose(0.0, 0.0, 0.45), np.array([0.0, 0.0, 0.02])


def ground(change=None):
    heights = np.zeros((201, 151), dtype=np.float32)
    x = (np.arange(201) - 100) * 0.02
    if change is not None:
        change(heights, x)
    return ElevationMap(heights, 0.02)


def planner(selector="oracle"):
    asked = []
    return StepPlanner(ROBOT, make_selector(selector), LINE, asked.append), asked


def test_on_level_ground_every_leg_gets_its_turn_and_its_stride():
    feet, base = FEET.copy(), BASE
    plans, asked = planner()
    legs = []
    for tick in range(8):
        step = plans.plan(float(tick), ground(), feet, base, COM)
        assert isinstance(step, Step)
        legs.append(step.leg)
        index = LEGS.index(step.leg)
        moved = step.goal - feet[index]
        assert 0.05 < moved[0] < 2 * STRIDE and abs(step.goal[1] - places()[index, 1]) < 0.1
        np.testing.assert_allclose(step.goal - step.foothold, [0, 0, RADIUS])
        # The centre of mass is over the other three when the leg lifts.
        corners = counter_clockwise(np.delete(feet, index, axis=0)[:, :2])
        lift = step.lift.answer.pose
        com = lift.position + lift.rotation() @ COM
        edges = np.roll(corners, -1, axis=0) - corners
        inside = (edges[:, 0] * (com[1] - corners[:, 1]) - edges[:, 1] * (com[0] - corners[:, 0])) / np.linalg.norm(
            edges, axis=1
        )
        assert inside.min() > LEAST_MARGIN
        feet[index], base = step.goal, step.touchdown
    assert legs == [*ORDER, *ORDER]
    assert len(asked) >= 8 and {choice.leg for choice in asked} == set(LEGS)


def test_a_nominal_foothold_in_a_gap_does_not_make_the_robot_crouch():
    """N_i lies in a trench half a metre deep, footholds on its banks: they are asked for at a pose that suits these."""
    plans, asked = planner()
    nominal = plans._nominal(FEET, LEGS.index("LH"), 1.0)

    def trench(heights, x):
        heights[np.abs(x - nominal[0]) < 0.075] = -0.5

    step = plans.plan(0.0, ground(trench), FEET, BASE, COM)
    first = asked[0]
    assert first.leg == "LH" and first.pose.z > 0.4 and abs(first.pose.roll) < 0.15 and abs(first.pose.pitch) < 0.15
    assert isinstance(step, Step) and step.foothold[2] == pytest.approx(0.0, abs=1e-3)


def test_steps_up_stairs_keep_all_limbs_clear_or_are_not_taken():
    """Stairs of 15 cm ahead of level ground: what a step is said to keep clear is what the planner lets pass."""

    def stairs(heights, x):
        heights += 0.15 * np.clip(np.ceil((x - 0.5) / 0.30), 0, 5)[:, None]

    feet, base = FEET.copy(), BASE
    plans, _ = planner()
    for tick in range(12):
        step = plans.plan(float(tick), ground(stairs), feet, base, COM)
        assert isinstance(step, Step) and step.lift.clearance > -LARGEST_LACK
        feet[LEGS.index(step.leg)], base = step.goal, step.touchdown
    assert feet[:2, 2].min() > 0.3 and base.pitch < -0.1


@pytest.mark.parametrize("selector", ["oracle", "cnn"])
def test_a_slope_is_climbed_although_level_ground_costs_less(selector):
    """The terrain cost likes the level ground before a slope of 18 degrees better than any cell of the slope."""

    def slope(heights, x):
        heights += np.tan(np.deg2rad(18)) * np.maximum(x - 0.45, 0.0)[:, None]

    feet, base = FEET.copy(), BASE
    plans, _ = planner(selector)
    for tick in range(24):
        step = plans.plan(float(tick), ground(slope), feet, base, COM)
        assert isinstance(step, Step)
        feet[LEGS.index(step.leg)], base = step.goal, step.touchdown
    assert feet[:2, 0].min() > 1.0 and feet[2:, 0].min() > 0.2


def test_a_leg_that_finds_no_gain_does_not_hold_up_the_others():
    """Footholds on the left alone end: it is the right legs' turn, or N_i further in or out is tried."""
    plans, _ = planner("nominal")

    def cliff(heights, x):
        heights[x > -0.3, :76] = np.nan

    step = plans.plan(0.0, ground(cliff), FEET, BASE, COM)
    assert isinstance(step, Step) and step.leg != "RF"


def test_where_nothing_is_known_it_says_that_there_is_no_step():
    plans, _ = planner()
    nowhere = ground(lambda heights, x: heights.__setitem__(x > -10, np.nan))
    answer = plans.plan(0.0, nowhere, FEET, BASE, COM)
    assert isinstance(answer, NoStep) and "no leg gets any further" in answer.reason


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.2, 0.0), (0.0, -0.25), (0.15, 0.2)])
def test_the_tilt_of_a_plane_is_that_of_a_base_on_it(roll, pitch):
    feet = np.column_stack([places(), np.zeros(4)]) @ tilt_rotation(roll, pitch).T
    np.testing.assert_allclose(plane_tilt(feet), [roll, pitch], atol=1e-9)


def test_the_normal_is_that_of_the_ground_under_the_foot():
    x = np.arange(201)[:, None] * 0.02
    sloped = ElevationMap(np.broadcast_to(0.2 * (x - 2.0), (201, 151)).astype(np.float32), 0.02)
    expected = np.array([-0.2, 0, 1]) / np.linalg.norm([-0.2, 0, 1])
    foot = np.array([0.1, 0.0, 0.02 + RADIUS])
    np.testing.assert_allclose(ground_normal(sloped, foot, RADIUS), expected, atol=1e-3)
    # A wall beside the foot is nothing that it stands on.
    beside = ground(lambda heights, x: heights.__setitem__(x > 0.03, 0.3))
    np.testing.assert_allclose(ground_normal(beside, np.array([0, 0, RADIUS]), RADIUS), [0, 0, 1], atol=1e-6)


def test_a_line_leads_there_and_back():
    line = Line(np.array([1.0, 2.0]), 0.7, 3.0)
    points = np.random.default_rng(0).normal(size=(5, 2))
    np.testing.assert_allclose(line.to_world(line.to_line(points)), points, atol=1e-12)
    np.testing.assert_allclose(line.to_line(np.array([1 + np.cos(0.7), 2 + np.sin(0.7)])), [1, 0], atol=1e-12)


@pytest.mark.parametrize("leg", LEGS)
def test_feet_keep_to_their_own_side(leg):
    """Of footholds that are alike the selector's own order counts, unless they leave no room for the other side."""
    plans, _ = planner()
    index = LEGS.index(leg)
    side = np.sign(places()[index, 1])
    points = np.array([[0.0, 0.2 * side, 0.0], [0.0, 0.02 * side, 0.0], [0.0, -0.1 * side, 0.0]])
    np.testing.assert_allclose(plans._width(leg, points), [0.2, 0.02, -0.1])
    narrow, wide = tuple(points[1] + [places()[index, 0], 0, 0]), tuple(points[0] + [places()[index, 0], 0, 0])
    choice = Foothold("ok", None, narrow, (0, 0), 10.0, 0, 10.0, narrow, 0.0, None, (Alternative(wide, 30.0),))
    now = Situation(ground(), FEET, BASE, COM)
    np.testing.assert_allclose(plans._lasting(now, leg, BASE, choice), wide)
