"""How the robot stands on level ground, and the geometry of any stance."""

import numpy as np
from numpy.typing import NDArray

from footsel.legs import LEGS, is_right

Array = NDArray[np.float64]

#: Where the feet of a level base belong: ahead of and beside its middle, below it. [m]
STANCE_LENGTH, STANCE_WIDTH, HEIGHT = 0.36, 0.245, 0.45


def places() -> Array:
    """(4, 2) where the feet belong about the base's middle, by LEGS, in [m]."""
    signs = np.array([[1.0 if leg[1] == "F" else -1.0, -1.0 if is_right(leg) else 1.0] for leg in LEGS])
    return signs * [STANCE_LENGTH, STANCE_WIDTH]


def plane_tilt(feet: Array) -> Array:
    """Roll and pitch (2,) of the plane through feet (n, 3) in a frame that has the base's heading, in [rad]."""
    offsets = feet - feet.mean(axis=0)
    slope_x, slope_y = np.linalg.lstsq(offsets[:, :2], offsets[:, 2], rcond=None)[0]
    pitch = -np.arctan(slope_x)
    return np.array([np.arctan(slope_y * np.cos(pitch)), pitch])


def counter_clockwise(corners: Array) -> Array:
    """Corners (k, 2 or 3) in counter-clockwise order around their middle, seen from above."""
    offsets = corners - corners.mean(axis=0)
    return np.asarray(corners[np.argsort(np.arctan2(offsets[:, 1], offsets[:, 0]))])
