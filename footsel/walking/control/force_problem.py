"""The whole-body problem, reduced to the contact forces: the part that is compiled.

Base (6) and feet (12) are as many directions as the robot has. So once the feet's accelerations are given, those of
the joints follow from the base's, and the base's from the forces on the feet:

    a_joints = e + E a_base,    a_base = G f + g,    tau = T f + t.

What is left to choose is f alone: 3 numbers per standing foot.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.compiled import compiled

Array = NDArray[np.float64]

#: Damps the inverse of a leg's Jacobian where it is nearly singular, knee nearly stretched. [m^2]
SINGULAR = 1e-4


@compiled
def reduce_to_forces(
    mass: Array, bias: Array, jacobian: Array, drift: Array, feet_acceleration: Array
) -> tuple[Array, Array, Array, Array]:  # pragma: no cover - compiled
    """G (6, 12), g (6,), T (12, 12), t (12,) for the forces of all four feet.

    mass (18, 18), bias (18,), jacobian (12, 18), drift (12,): of the equations of motion (see Motion).
    feet_acceleration: (12,) wanted, in W, in [m/s^2].
    """
    E, e = np.zeros((12, 6)), np.zeros(12)
    for k in range(4):
        rows = slice(3 * k, 3 * k + 3)
        leg = np.ascontiguousarray(jacobian[rows, 6 + 3 * k : 9 + 3 * k])
        square = leg @ leg.T
        # Damping grows as the leg loses a direction, and is nothing elsewhere.
        lost = max(0.0, 1 - abs(np.linalg.det(leg)) / 0.003)
        for i in range(3):
            square[i, i] += SINGULAR * lost * lost
        inverse = leg.T @ np.linalg.inv(square)
        E[rows] = -inverse @ np.ascontiguousarray(jacobian[rows, :6])
        e[rows] = inverse @ (feet_acceleration[rows] - drift[rows])
    base_joints = np.ascontiguousarray(mass[:6, 6:])
    base = np.ascontiguousarray(mass[:6, :6]) + base_joints @ E
    on_base = np.ascontiguousarray(jacobian[:, :6].T)
    G = np.linalg.solve(base, on_base)
    g = -np.linalg.solve(base, bias[:6] + base_joints @ e)
    joints = np.ascontiguousarray(mass[6:, 6:])
    by_base = np.ascontiguousarray(mass[6:, :6]) + joints @ E
    T = by_base @ G
    for k in range(4):
        rows = slice(3 * k, 3 * k + 3)
        T[rows, rows] -= jacobian[rows, 6 + 3 * k : 9 + 3 * k].T
    t = by_base @ g + joints @ e + bias[6:]
    return G, g, T, t  # type: ignore[return-value]


@compiled
def force_problem(  # noqa: PLR0912 - compiled: loops over four feet
    G: Array,
    g: Array,
    T: Array,
    t: Array,
    base_acceleration: Array,
    base_weights: Array,
    normals: Array,
    limits: Array,
    friction: float,
    force_weights: tuple[float, float],
    torque_limit: float,
) -> tuple[Array, Array, Array, Array]:  # pragma: no cover - compiled
    """The quadratic programme `min 1/2 f'Hf - c'f` subject to `A'f >= b` over the standing feet's forces.

    base_acceleration: (6,) wanted, in the base frame. base_weights: (6,). force_weights: normal, tangential.
    normals: (4, 3) of the ground under the feet, in W. limits: (4, 2) least and largest normal force, in [N]; a foot
    whose largest is 0 does not stand and has no variables.
    """
    standing = np.array([k for k in range(4) if limits[k, 1] > 0])
    n = 3 * len(standing)
    columns = np.empty(n, dtype=np.int64)
    for s in range(len(standing)):
        for axis in range(3):
            columns[3 * s + axis] = 3 * standing[s] + axis
    Gs, Ts = np.empty((6, n)), np.empty((12, n))
    for c in range(n):
        Gs[:, c] = G[:, columns[c]]
        Ts[:, c] = T[:, columns[c]]
    weighted = np.empty((n, 6))
    for c in range(n):
        for r in range(6):
            weighted[c, r] = Gs[r, c] * base_weights[r]
    H = weighted @ Gs
    c_vector = weighted @ (base_acceleration - g)
    for s in range(len(standing)):
        normal = normals[standing[s]]
        for i in range(3):
            H[3 * s + i, 3 * s + i] += force_weights[1]
            for j in range(3):
                H[3 * s + i, 3 * s + j] += (force_weights[0] - force_weights[1]) * normal[i] * normal[j]

    rows = 6 * len(standing) + 24
    A, b = np.zeros((n, rows)), np.empty(rows)
    row = 0
    for s in range(len(standing)):
        normal = normals[standing[s]]
        # Two tangents, one of them without a y component.
        scale = np.sqrt(normal[0] ** 2 + normal[2] ** 2)
        first = np.array([normal[2] / scale, 0.0, -normal[0] / scale])
        second = np.cross(normal, first)
        for tangent in (first, second):
            for sign in (1.0, -1.0):
                for axis in range(3):
                    A[3 * s + axis, row] = friction * normal[axis] + sign * tangent[axis]
                b[row] = 0.0
                row += 1
        for axis in range(3):
            A[3 * s + axis, row] = normal[axis]
            A[3 * s + axis, row + 1] = -normal[axis]
        b[row] = limits[standing[s], 0]
        b[row + 1] = -limits[standing[s], 1]
        row += 2
    for joint in range(12):
        for c in range(n):
            A[c, row] = Ts[joint, c]
            A[c, row + 1] = -Ts[joint, c]
        b[row] = -torque_limit - t[joint]
        b[row + 1] = -torque_limit + t[joint]
        row += 2
    return H, c_vector, A, b
