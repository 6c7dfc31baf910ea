"""The base is balanced, in reach, and nowhere better."""

from dataclasses import replace

import numpy as np
import pytest

from footsel.footholds import BasePose
from footsel.robot import load_robot
from footsel.walking.control import base_pose
from footsel.walking.control.base_pose import STABILITY_MARGIN, PoseProblem, inward_edges, optimise_base_pose
from footsel.walking.control.leg_length import LegLength
from footsel.walking.control.limb_clearance import Clearance
from footsel.walking.gait.stance import counter_clockwise, places

LENGTHS = LegLength(load_robot("anymal_b"))
HIPS = LENGTHS.hips
FEET = np.column_stack([places(), np.full(4, 0.031)])


def problem(feet=FEET, lifted=0, yaw=0.0):
    support = counter_clockwise(np.delete(feet, lifted, axis=0)[:, :2])
    place = np.array([*feet[:, :2].mean(axis=0), 0.45])
    return PoseProblem(yaw, place, np.zeros(2), LENGTHS, feet, np.array([0.0, 0.0, 0.02]), support)


@pytest.mark.parametrize("lifted", range(4))
def test_it_stands_safely_over_three_feet(lifted):
    answer = optimise_base_pose(problem(lifted=lifted), BasePose(0, 0, 0.45))
    assert answer.margin > STABILITY_MARGIN - 2e-3 and answer.overreach < 1e-3
    # It sways no further than it has to.
    assert answer.margin < STABILITY_MARGIN + 5e-3


def test_no_pose_near_it_is_better():
    """Of those that are as stable, none is nearer to where the base should be."""
    asked = problem()
    answer = optimise_base_pose(asked, BasePose(0, 0, 0.45))

    def price(pose):
        away = np.sum((pose[:3] - asked.place) ** 2) + base_pose.TILT_WEIGHT * np.sum(pose[3:] ** 2)
        points, _ = base_pose._move(0.0, pose, np.concatenate([asked.com[None], HIPS]))
        normals, offsets = inward_edges(asked.support)
        short = max(0.0, STABILITY_MARGIN - float((normals @ points[0][:2] - offsets).min()))
        lengths = LENGTHS.between(points[1:], FEET)
        reach = max(0.0, float((lengths - base_pose.LONGEST_LEG).max()))
        comfort = np.maximum(lengths - base_pose.COMFORTABLE_LEG, 0)
        bounds = base_pose.BOUND_WEIGHT * (short**2 + reach**2)
        return away + bounds + base_pose.COMFORT_WEIGHT * np.sum(comfort**2)

    best = np.array([answer.pose.x, answer.pose.y, answer.pose.z, answer.pose.roll, answer.pose.pitch])
    rng = np.random.default_rng(0)
    others = [price(best + rng.normal(size=5) * rng.choice([1e-3, 1e-2, 5e-2])) for _ in range(400)]
    assert price(best) <= min(others) + 1e-6


def test_it_keeps_away_from_a_foot_that_swings_by():
    """A foot lifted to 16 cm below its hip: the base goes out of its way, and no further than it has to."""
    plain = problem()
    free = optimise_base_pose(plain, BasePose(0, 0, 0.45)).pose
    passing = FEET.copy()
    passing[0] = free.position + free.rotation() @ HIPS[0] - [0.0, 0.0, 0.16]

    def length(pose):
        return float(LENGTHS.between(pose.position + pose.rotation() @ HIPS[0], passing[0]))

    aware = optimise_base_pose(replace(plain, passing=passing), free)
    assert length(free) < base_pose.FOLDED_LEG - 0.02
    assert length(aware.pose) == pytest.approx(base_pose.FOLDED_LEG, abs=5e-3)
    assert aware.margin > STABILITY_MARGIN - 5e-3


def test_feet_out_of_reach_are_said_to_be():
    far = FEET * [2.4, 2.4, 1.0]
    answer = optimise_base_pose(problem(far), BasePose(0, 0, 0.45))
    assert answer.overreach > 0.02


def test_a_turned_and_moved_stance_gets_a_turned_and_moved_pose():
    here = optimise_base_pose(problem(), BasePose(0, 0, 0.45))
    yaw, shift = 0.8, np.array([1.0, -2.0, 0.0])
    c, s = np.cos(yaw), np.sin(yaw)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    there = optimise_base_pose(problem(FEET @ turn.T + shift, yaw=yaw), BasePose(1, -2, 0.45, yaw=yaw))
    np.testing.assert_allclose(there.pose.position, turn @ here.pose.position + shift, atol=1e-4)
    np.testing.assert_allclose([there.pose.roll, there.pose.pitch], [here.pose.roll, here.pose.pitch], atol=1e-3)
    assert there.margin == pytest.approx(here.margin, abs=1e-4)


def test_rates_are_those_of_the_points():
    values, points = np.array([0.1, 0.2, 0.4, 0.2, -0.3]), HIPS
    _, rates = base_pose._move(0.7, values, points)
    for axis in range(5):
        shift = 1e-6 * np.eye(5)[axis]
        (after, _), (before, _) = (base_pose._move(0.7, values + sign * shift, points) for sign in (1, -1))
        np.testing.assert_allclose(rates[:, :, axis], (after - before) / 2e-6, atol=1e-8)


def test_what_cannot_be_met_is_missed_by_little():
    """A support so thin that no point is as far inside as asked for: the middle of it is taken."""
    thin = replace(problem(), support=np.array([[-0.3, -0.02], [0.3, -0.02], [0.3, 0.02], [-0.3, 0.02]]))
    answer = optimise_base_pose(thin, BasePose(0, 0, 0.45))
    assert answer.margin == pytest.approx(0.02, abs=2e-3)


def test_it_rises_for_limbs_as_far_as_they_ask():
    """Limbs over a ground 1 cm too high, whose clearance grows by half of the base's rise: it rises by 2 cm."""
    free = optimise_base_pose(problem(), BasePose(0, 0, 0.45))

    def limbs(pose):
        least, rates = np.full((4, 2), np.inf), np.zeros((4, 2, 5))
        least[2, 0], rates[2, 0, 2] = 0.5 * (pose.z - free.pose.z) - 0.01, 0.5
        return Clearance(least, rates)

    answer = optimise_base_pose(replace(problem(), limbs=limbs), BasePose(0, 0, 0.45))
    assert answer.pose.z - free.pose.z == pytest.approx(0.02, abs=1e-3) and abs(answer.clearance) < 1e-3
