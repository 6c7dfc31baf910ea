"""Whole-body control: torques that move base and feet as told, with forces that the ground can give."""

from dataclasses import dataclass

import numpy as np
import quadprog
from numpy.typing import NDArray

from footsel.walking.control.dynamics import Motion
from footsel.walking.control.force_problem import force_problem, reduce_to_forces
from footsel.walking.vectors import cross

Array = NDArray[np.float64]

#: What the drives give (effort limits of ANYmal B's URDF). [Nm]
TORQUE_LIMIT = 80.0
#: Of the pyramid, along each of its axes: its corners, 1.41 times as far, stay below the true friction, with a reserve
#: for errors of the normal.
FRICTION = 0.45
#: Worth of the base's linear and angular accelerations; yaw is worth less, or feet would twist against the ground
#: whenever a leg swings.
BASE_WEIGHTS = np.array([10.0, 10.0, 10.0, 10.0, 10.0, 3.0])
#: Worth of small normal and tangential forces beside them.
FORCE_WEIGHTS = (1e-4, 5e-4)


@dataclass(frozen=True, eq=False)
class Task:
    """What base and feet should do at one time.

    base_acceleration: (6,) linear then angular, in W, in [m/s^2] and [rad/s^2].
    feet_acceleration: (4, 3) by LEGS, in W, in [m/s^2].
    normals: (4, 3) of the ground under the feet. limits: (4, 2) least and largest normal force, in [N]; (0, 0) for a
    foot in the air.
    """

    base_acceleration: Array
    feet_acceleration: Array
    normals: Array
    limits: Array


@dataclass(frozen=True, eq=False)
class Effort:
    """torques: (12,) in [Nm]. forces: (4, 3) expected of the ground on the feet, in W, in [N]."""

    torques: Array
    forces: Array


def whole_body_effort(motion: Motion, rotation: Array, linear: Array, angular: Array, task: Task) -> Effort:
    """Torques for a task at a state: feet as told exactly, the base as well as forces and torques allow.

    rotation: (3, 3) of the base in W. linear, angular: (3,) the base's velocity in W.
    """
    # The acceleration of a point, seen from the turning base frame.
    wanted = np.empty(6)
    wanted[:3] = (task.base_acceleration[:3] - cross(angular.tolist(), linear.tolist())) @ rotation
    wanted[3:] = task.base_acceleration[3:] @ rotation
    G, g, T, t = reduce_to_forces(
        motion.mass, motion.bias, motion.jacobian, motion.drift, task.feet_acceleration.ravel()
    )
    H, c, A, b = force_problem(
        G, g, T, t, wanted, BASE_WEIGHTS, task.normals, task.limits, FRICTION, FORCE_WEIGHTS, TORQUE_LIMIT
    )
    standing = task.limits[:, 1] > 0
    forces = np.zeros((4, 3))
    forces[standing] = _solve(H, c, A, b).reshape(-1, 3)
    torques = T @ forces.ravel() + t
    return Effort(np.clip(torques, -TORQUE_LIMIT, TORQUE_LIMIT), forces)


def _solve(H: Array, c: Array, A: Array, b: Array) -> Array:
    try:
        return np.asarray(quadprog.solve_qp(H, c, A, b)[0])
    except ValueError:
        # No forces keep the torques within their limits: let the drives saturate.
        free = A.shape[1] - 24
        return np.asarray(quadprog.solve_qp(H, c, A[:, :free], b[:free])[0])
