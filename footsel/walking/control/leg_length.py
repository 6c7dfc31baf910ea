"""How long legs are, from the axis of flexion to the foot's centre: stretched, a knee may turn over."""

import numpy as np
from numpy.typing import NDArray

from footsel.legs import LEGS
from footsel.robot.robot import Robot

Array = NDArray[np.float64]


class LegLength:
    """Lengths within the planes of the legs, whatever their abduction.

    hips: (4, 3) points of the axes of abduction, by LEGS, in the base frame, beside which the legs hang, in [m].
    offset: of the legs' planes from these axes, in [m].
    """

    def __init__(self, robot: Robot) -> None:
        legs = [robot.kinematics[leg] for leg in LEGS]
        self.hips = np.array([leg.haa + leg.hfe_offset[0] * leg.basis[0] for leg in legs])
        self.offset = abs(legs[0].plane_offset)

    def between(self, hips: Array, feet: Array) -> Array:
        """(...,) from hips (..., 3), points as in `hips`, to the feet's centres (..., 3), all in one frame, in [m]."""
        square = ((hips - feet) ** 2).sum(axis=-1) - self.offset**2
        return np.asarray(np.sqrt(np.maximum(square, 1e-4)))
