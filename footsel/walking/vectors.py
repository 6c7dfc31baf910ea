"""Small vectors, many times a second: what numpy does more slowly for three numbers than Python itself."""

from collections.abc import Sequence
from math import sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triple = Sequence[float]


def cross(a: Triple, b: Triple) -> Array:
    """(3,) cross product of two sequences of three floats."""
    ax, ay, az = a
    bx, by, bz = b
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def length(a: Triple) -> float:
    """Euclidean length of three floats."""
    x, y, z = a
    return sqrt(x * x + y * y + z * z)


def rotated(quaternion_xyzw: Sequence[float], a: Triple) -> tuple[float, float, float]:
    """A vector turned by a unit quaternion."""
    x, y, z, w = quaternion_xyzw
    ax, ay, az = a
    tx, ty, tz = 2 * (y * az - z * ay), 2 * (z * ax - x * az), 2 * (x * ay - y * ax)
    return ax + w * tx + y * tz - z * ty, ay + w * ty + z * tx - x * tz, az + w * tz + x * ty - y * tx


def rotation(quaternion_xyzw: Sequence[float]) -> Array:
    """(3, 3) matrix of a unit quaternion."""
    x, y, z, w = quaternion_xyzw
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
