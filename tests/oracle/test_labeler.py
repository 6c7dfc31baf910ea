"""Laws of a label: what its arrays hold, and how it follows the terrain, the tilt and the side of the robot."""

import numpy as np
import pytest

from footsel.footholds import Reason
from footsel.footholds.cost import INFEASIBLE_COST, foothold_cost
from footsel.footholds.pose import tilt_rotation
from footsel.legs import LEGS, mirror_of
from footsel.oracle import Label, Oracle
from footsel.terrain import LocalMap
from footsel.terrain.courses import make_course


@pytest.fixture(scope="module")
def oracle() -> Oracle:
    return Oracle.load("anymal_b")


def local_map(heights: np.ndarray) -> LocalMap:
    return LocalMap(np.asarray(heights, dtype=np.float32), 0.02, np.zeros(3), 0.0)


def course_map(family: str, seed: int, depth: float = 0.45) -> LocalMap:
    elevation = make_course(family, seed).elevation[100:140, 100:140]
    return local_map(elevation - np.median(elevation) - depth)


def check_arrays(label: Label, heights: np.ndarray) -> None:
    unknown, feasible = np.isnan(heights), label.feasible
    np.testing.assert_array_equal(label.reason == Reason.UNKNOWN, unknown)
    np.testing.assert_array_equal(label.cost < INFEASIBLE_COST, feasible)
    np.testing.assert_array_equal(label.cost_image < INFEASIBLE_COST, feasible)
    np.testing.assert_array_equal(~np.isnan(label.kinematic_margin), feasible)
    np.testing.assert_array_equal(~np.isnan(label.terrain_cost), ~unknown)
    in_range = ~np.isin(label.reason, [Reason.UNKNOWN, Reason.KINEMATIC_RANGE])
    np.testing.assert_array_equal(~np.isnan(label.joint_angles).any(axis=-1), in_range)


@pytest.mark.parametrize("family", ["flat", "stones", "pillars", "rubble"])
@pytest.mark.parametrize("leg", LEGS)
def test_arrays_agree_with_reasons(oracle: Oracle, family: str, leg: str) -> None:
    heights = course_map(family, 2).heights.copy()
    heights[np.random.default_rng(0).random(heights.shape) < 0.1] = np.nan
    check_arrays(oracle.label(local_map(heights), leg, 0.1, -0.1), heights)


def test_cost_is_equation_1_of_margin_and_terrain(oracle: Oracle) -> None:
    label = oracle.label(course_map("rough", 1), "LH")
    ok = label.feasible
    margin_cost = 1 - label.kinematic_margin[ok] / oracle.robot.margin_max("LH")
    np.testing.assert_allclose(label.cost[ok], foothold_cost(margin_cost, label.terrain_cost[ok]))


def test_joint_angles_put_the_foot_on_the_cell(oracle: Oracle) -> None:
    ground = course_map("slopes", 3)
    roll, pitch = 0.12, -0.2
    label = oracle.label(ground, "RF", roll, pitch)
    in_range = ~np.isnan(label.joint_angles).any(axis=-1)
    feet = oracle.robot.kinematics["RF"].forward(label.joint_angles[in_range]) @ tilt_rotation(roll, pitch).T
    contacts = feet - [0, 0, oracle.robot.layout.foot_radius]
    np.testing.assert_allclose(contacts, ground.positions()[in_range], atol=1e-6)


@pytest.mark.parametrize("leg", ["LF", "LH"])
def test_flat_ground_mirrors_between_sides(oracle: Oracle, leg: str) -> None:
    flat = local_map(np.full((40, 40), -0.45))
    left, right = oracle.label(flat, leg, 0.1, 0.05), oracle.label(flat, mirror_of(leg), -0.1, 0.05)
    np.testing.assert_array_equal(left.reason, right.reason[:, ::-1])
    np.testing.assert_allclose(left.cost, right.cost[:, ::-1], atol=1e-4)
    np.testing.assert_allclose(left.joint_angles, right.joint_angles[:, ::-1] * [-1, 1, 1], atol=1e-9)


def test_rolling_the_base_moves_the_reach_sideways(oracle: Oracle) -> None:
    """Positive roll lifts the left side and turns the base's downward axis towards +y."""
    flat = local_map(np.full((40, 40), -0.42))

    def middle(roll: float) -> float:
        return float(np.argwhere(oracle.label(flat, "LF", roll, 0.0).feasible)[:, 1].mean())

    assert middle(-0.2) < middle(0.0) < middle(0.2)


def test_deep_and_unknown_ground(oracle: Oracle) -> None:
    deep = oracle.label(local_map(np.full((40, 40), -2.0)), "LF")
    assert (deep.reason == Reason.KINEMATIC_RANGE).all()
    unknown = oracle.label(local_map(np.full((40, 40), np.nan)), "LF")
    assert (unknown.reason == Reason.UNKNOWN).all()
    lone = np.full((40, 40), np.nan)
    lone[20, 20] = -0.45
    label = oracle.label(local_map(lone), "LF")
    assert label.reason[20, 20] == Reason.FEASIBLE and label.terrain_cost[20, 20] == 1.0


def test_a_wall_beside_the_foot_makes_the_leg_collide(oracle: Oracle) -> None:
    heights = np.full((40, 40), -0.45)
    free = oracle.label(local_map(heights), "LF")
    # The hip is behind the wall, so footholds ahead of it are reached through it.
    heights[24:26, :] = -0.05
    walled = oracle.label(local_map(heights), "LF")
    lost = free.feasible & (walled.reason == Reason.TERRAIN_COLLISION)
    assert lost[26:].sum() > 300
    assert lost[:23].sum() < 10
    # A wall takes footholds away and gives none.
    assert not (walled.feasible & ~free.feasible)[np.r_[:24, 26:40]].any()
