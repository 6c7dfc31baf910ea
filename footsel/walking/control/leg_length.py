"""How long legs are, from the axis of flexion to the foot's centre, and how far below the axis of abduction it is.

Stretched, a knee may turn over; beside the axis of abduction, the whole leg.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.legs import LEGS
from footsel.robot.robot import Robot

Array = NDArray[np.float64]


class LegLength:
    """Lengths within the planes of the legs, whatever their abduction.

    hips: (4, 3) points of the axes of abduction, by LEGS, in the base frame, beside which the legs hang, in [m].
    offset: of the legs' planes from these axes, in [m]. axis: (3,) their direction in the base frame, along the base.
    """

    def __init__(self, robot: Robot) -> None:
        legs = [robot.kinematics[leg] for leg in LEGS]
        self.hips = np.array([leg.haa + leg.hfe_offset[0] * leg.basis[0] for leg in legs])
        self.offset = abs(legs[0].plane_offset)
        self.axis = legs[0].basis[0]

    def between(self, hips: Array, feet: Array) -> Array:
        """(...,) from hips (..., 3), points as in `hips`, to the feet's centres (..., 3), all in one frame, in [m]."""
        square = ((hips - feet) ** 2).sum(axis=-1) - self.offset**2
        return np.asarray(np.sqrt(np.maximum(square, 1e-4)))

    def depth(self, rotation: Array, hip: Array, foot: Array) -> float:
        """Within its plane, a foot's distance from the axis of abduction, no more than the leg's length, in [m].

        The smaller, the faster the leg has to turn about that axis; at 0 the foot is as near as it ever gets.
        rotation: (3, 3) of the base. hip: (3,) a point as in `hips`. foot: (3,) its centre; both in W, in [m].
        """
        across = np.cross(rotation @ self.axis, hip - foot)
        return float(np.sqrt(max(float(across @ across) - self.offset**2, 0.0)))
