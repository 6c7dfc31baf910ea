"""Whole-body control: torques that move base and feet as told, with forces that the ground can give."""

from dataclasses import dataclass

import numpy as np
import quadprog
from numpy.typing import NDArray

from footsel.walking.control.dynamics import Motion
from footsel.walking.control.force_problem import force_problem, reduce_to_forces

Array = NDArray[np.float64]

#: What the drives give (effort limits of ANYmal B's URDF). [Nm]
TORQUE_LIMIT = 80.0
#: Below the true friction, so that an error of the normal does not make a foot slip.
FRICTION = 0.55
#: Worth of the base's linear and angular accelerations beside the forces: these only choose among equals.
BASE_WEIGHTS = np.array([10.0, 10.0, 10.0, 10.0, 10.0, 10.0])
FORCE_WEIGHT = 1e-4


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
    wanted = np.concatenate(
        [
            (task.base_acceleration[:3] - np.cross(angular, linear)) @ rotation,
            task.base_acceleration[3:] @ rotation,
        ]
    )
    G, g, T, t = reduce_to_forces(
        motion.mass, motion.bias, motion.jacobian, motion.drift, task.feet_acceleration.ravel()
    )
    H, c, A, b = force_problem(
        G, g, T, t, wanted, BASE_WEIGHTS, task.normals, task.limits, FRICTION, FORCE_WEIGHT, TORQUE_LIMIT
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
