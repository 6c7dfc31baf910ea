"""Torques obey the equations of motion, and forces the ground."""

import numpy as np
import pinocchio as pin
import pytest

from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.walking.control.dynamics import Dynamics
from footsel.walking.control.whole_body import FRICTION, TORQUE_LIMIT, Task, whole_body_effort
from footsel.walking.state import RobotState

ROBOT = load_robot("anymal_b")
DYNAMICS = Dynamics(ROBOT)
STANCE = np.concatenate([ROBOT.description.stance[leg] for leg in LEGS])


def a_state(seed):
    rng = np.random.default_rng(seed)
    base = np.eye(4)
    base[:3, :3] = pin.rpy.rpyToMatrix(*rng.uniform(-0.15, 0.15, 2), rng.uniform(-3, 3))
    moving = 0.2 * rng.normal(size=18)
    joints = STANCE + rng.uniform(-0.1, 0.1, 12)
    return RobotState(0.0, base, moving[:3], moving[3:6], joints, moving[6:], np.zeros((4, 3)))


def a_task(seed, flying=None, push=1.0):
    rng = np.random.default_rng([seed, 1])
    limits = np.tile([5.0, 450.0], (4, 1))
    if flying is not None:
        limits[flying] = 0.0
    feet = np.zeros((4, 3))
    if flying is not None:
        feet[flying] = rng.uniform(-5, 5, 3)
    return Task(push * rng.uniform(-0.5, 0.5, 6), feet, np.tile([0.0, 0.0, 1.0], (4, 1)), limits)


@pytest.mark.parametrize("flying", [None, 0, 3])
@pytest.mark.parametrize("seed", range(4))
def test_torques_and_forces_move_base_and_feet_as_told(seed, flying):
    state, task = a_state(seed), a_task(seed, flying, push=0.3)
    motion, turn = DYNAMICS.at(state), state.base[:3, :3]
    effort = whole_body_effort(motion, turn, state.linear, state.angular, task)
    pushed = np.concatenate([np.zeros(6), effort.torques]) + motion.jacobian.T @ effort.forces.ravel()
    acceleration = np.linalg.solve(motion.mass, pushed - motion.bias)
    feet = motion.jacobian @ acceleration + motion.drift
    np.testing.assert_allclose(feet.reshape(4, 3), task.feet_acceleration, atol=1e-6)
    linear = turn @ acceleration[:3] + np.cross(state.angular, state.linear)
    moved = np.concatenate([linear, turn @ acceleration[3:6]])
    if flying is None:
        np.testing.assert_allclose(moved, task.base_acceleration, atol=0.05)
    else:  # Over three feet the base does what it can; the one in the air pushes nothing.
        assert not effort.forces[flying].any()


@pytest.mark.parametrize("seed", range(6))
def test_the_ground_can_give_the_forces(seed):
    """Even for a base that is told to do more than feet can push."""
    state, task = a_state(seed), a_task(seed, flying=seed % 4, push=40.0)
    slope = np.array([0.2, -0.1, 1.0]) / np.linalg.norm([0.2, -0.1, 1.0])
    task = Task(task.base_acceleration, task.feet_acceleration, np.tile(slope, (4, 1)), task.limits)
    effort = whole_body_effort(DYNAMICS.at(state), state.base[:3, :3], state.linear, state.angular, task)
    standing = task.limits[:, 1] > 0
    normal = effort.forces[standing] @ slope
    tangential = np.linalg.norm(effort.forces[standing] - normal[:, None] * slope, axis=1)
    assert (normal >= 5 - 1e-6).all() and (normal <= 450 + 1e-6).all()
    assert (tangential <= np.sqrt(2) * FRICTION * normal + 1e-6).all()
    assert np.abs(effort.torques).max() <= TORQUE_LIMIT


def test_standing_still_carries_the_weight():
    state = RobotState(0.0, np.eye(4), np.zeros(3), np.zeros(3), STANCE, np.zeros(12), np.zeros((4, 3)))
    task = Task(np.zeros(6), np.zeros((4, 3)), np.tile([0.0, 0.0, 1.0], (4, 1)), np.tile([5.0, 450.0], (4, 1)))
    forces = whole_body_effort(DYNAMICS.at(state), np.eye(3), np.zeros(3), np.zeros(3), task).forces
    np.testing.assert_allclose(forces.sum(axis=0), [0, 0, 9.81 * DYNAMICS.total_mass], atol=1.0)
