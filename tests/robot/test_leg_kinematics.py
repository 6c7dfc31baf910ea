"""The closed form against Pinocchio, against rotation matrices of a synthetic leg, and against its own laws."""

from itertools import product

import numpy as np
import pinocchio as pin
import pytest

from footsel.errors import InputError
from footsel.legs import LEGS, mirror_of
from footsel.robot import load_robot
from footsel.robot.leg_kinematics import LegKinematics

MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal_b")


def pinocchio_foot(robot, leg, angles):
    """(n, 3) foot centres relative to the hip point, the joints of the whole robot addressed by name."""
    model, data = robot.model, robot.model.createData()
    index = [model.joints[model.getJointId(name)].idx_q for name in robot.description.joints[leg]]
    feet = []
    for row in angles:
        configuration = pin.neutral(model)
        configuration[index] = row
        pin.framesForwardKinematics(model, data, configuration)
        feet.append(data.oMf[robot.foot_frames[leg]].translation - robot.layout.hips[leg])
    return np.array(feet)


def in_limits(limits, count, seed=0):
    low, high = np.array(limits).T
    return np.random.default_rng(seed).uniform(low, high, (count, 3))


@pytest.mark.parametrize("leg", LEGS)
def test_forward_is_pinocchios(robot, leg):
    angles = np.random.default_rng(1).uniform(-3, 3, (300, 3))
    feet = robot.kinematics[leg].forward(angles)
    np.testing.assert_allclose(feet, pinocchio_foot(robot, leg, angles), rtol=0, atol=1e-12)


@pytest.mark.parametrize("leg", LEGS)
def test_inverse_puts_pinocchios_foot_on_the_target(robot, leg):
    targets = np.random.default_rng(2).uniform([-0.4, -0.4, -0.6], [0.4, 0.4, 0.1], (2000, 3))
    angles, reachable = robot.kinematics[leg].inverse(targets)
    assert 300 < reachable.sum() < 1700
    feet = pinocchio_foot(robot, leg, angles[reachable])
    np.testing.assert_allclose(feet, targets[reachable], rtol=0, atol=1e-12)
    low, high = np.array(robot.description.limits[leg]).T
    assert ((angles[reachable] >= low) & (angles[reachable] <= high)).all()
    finite = np.isfinite(angles).all(axis=1)
    outside = ((angles[finite] < low) | (angles[finite] > high)).any(axis=1)
    np.testing.assert_array_equal(~reachable[finite], outside)


@pytest.mark.parametrize("leg", LEGS)
def test_inverse_finds_the_configuration_of_the_nominal_branch(robot, leg):
    kinematics = robot.kinematics[leg]
    angles = in_limits(robot.description.limits[leg], 5000)
    feet = kinematics.forward(angles)
    # Below the hip: the foot's height in the leg plane is that at zero abduction.
    below = kinematics.forward(angles * [0.0, 1.0, 1.0])[:, 2] < -1e-6
    found, reachable = kinematics.inverse(feet)
    assert reachable[below].all()
    np.testing.assert_allclose(found[below], angles[below], atol=1e-6)
    # A foot above the hip is met by another configuration or by none, never by one above the hip.
    above = reachable & ~below
    assert (kinematics.forward(found[above] * [0.0, 1.0, 1.0])[:, 2] < 1e-6).all()


@pytest.mark.parametrize("leg", LEGS)
def test_the_nominal_stance_is_found_again(robot, leg):
    stance = robot.description.stance[leg]
    angles, reachable = robot.kinematics[leg].inverse(robot.kinematics[leg].forward(stance))
    assert reachable.all()
    np.testing.assert_allclose(angles[0], stance, atol=1e-12)


@pytest.mark.parametrize("leg", ["LF", "LH"])
def test_legs_mirror(robot, leg):
    angles = np.random.default_rng(3).uniform(-2, 2, (200, 3))
    here = robot.kinematics[leg].forward(angles)
    there = robot.kinematics[mirror_of(leg)].forward(angles * [-1.0, 1.0, 1.0])
    np.testing.assert_allclose(there, here * MIRROR, atol=1e-12)
    hind = {"LF": "LH", "LH": "LF"}[leg]
    other = robot.kinematics[hind].forward(angles * [1.0, -1.0, -1.0])
    np.testing.assert_allclose(other, here * [-1.0, 1.0, 1.0], atol=1e-12)


def test_out_of_reach(robot):
    kinematics = robot.kinematics["LF"]
    targets = [[0.0, 0.0, -0.6], [0.0, -0.13, 0.0], [2.0, 0.0, -0.4]]
    angles, reachable = kinematics.inverse(targets)
    assert not reachable.any()
    assert np.isnan(angles).any(axis=1).all()


# Zero configurations of a leg: hip, knee and foot points, offsets and all, in metres.
POINTS = np.array([[0.37, 0.2, 0.0], [0.45, 0.29, 0.02], [0.47, 0.33, -0.33]])
FOOT = np.array([0.4, 0.31, -0.66])


def turn(point, origin, axis, angle):
    """Rodrigues' formula, about an axis through a point."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return origin + rotation @ (point - origin)


@pytest.mark.parametrize("signs", list(product((1.0, -1.0), repeat=3)))
@pytest.mark.parametrize("knee_side", [-1.0, 1.0])
@pytest.mark.parametrize("heading", [0.0, np.pi, 0.7])
def test_any_axis_signs_and_knee_directions(signs, knee_side, heading):
    """HyQ's axes are reversed, ANYmal C's legs each have their own, Unitree's knees all point one way."""
    c, s = np.cos(heading), np.sin(heading)
    yaw = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    axes = np.array([[signs[0], 0, 0], [0, signs[1], 0], [0, signs[2], 0]]) @ yaw.T
    points, foot = POINTS @ yaw.T, yaw @ FOOT
    # In this leg a bend of knee_side about the y axis, well past the stretched knee, whatever the axis' sign.
    knee = sorted((knee_side * 0.6 * signs[2], knee_side * 2.2 * signs[2]))
    limits = [(-1.0, 1.0), (-1.6, 1.6), knee]
    leg = LegKinematics.from_axes(points, axes, foot, [0.0, 0.0, np.mean(knee)], limits)

    angles = in_limits(limits, 300, seed=4)
    expected = []
    for q in angles:
        position = foot
        for joint in (2, 1, 0):
            position = turn(position, points[joint], axes[joint], q[joint])
        expected.append(position - leg.hip)
    np.testing.assert_allclose(leg.forward(angles), expected, atol=1e-12)

    found, reachable = leg.inverse(expected)
    below = leg.forward(angles * [0.0, 1.0, 1.0])[:, 2] + leg.hip[2] < points[0, 2] - 1e-6
    assert below.sum() > 200
    assert reachable[below].all()
    np.testing.assert_allclose(found[below], angles[below], atol=1e-9)
    np.testing.assert_allclose(leg.forward(found[reachable]), np.array(expected)[reachable], atol=1e-12)


def test_other_legs_are_refused():
    axes = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    with pytest.raises(InputError, match="HAA perpendicular to HFE parallel to KFE"):
        LegKinematics.from_axes(POINTS, axes, FOOT, np.zeros(3), [(-1, 1)] * 3)
    slanted = np.array([[0.8, 0.6, 0], [0, 1.0, 0], [0, 1.0, 0]])
    with pytest.raises(InputError, match="another solver"):
        LegKinematics.from_axes(POINTS, slanted, FOOT, np.zeros(3), [(-1, 1)] * 3)
