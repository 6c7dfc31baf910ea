"""The base's tilt as a network's fixed layers need it."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds.encoding import TILT_RANGE
from footsel.learning.constants import keep_constant
from footsel.learning.precision import own_precision

#: Every entry of Ry(pitch) Rx(roll) is a product of two of: cosines of roll and pitch, their sines, and 1, or of their
#: negatives. Row by row, which two.
_FIRST = ("cos_pitch", "sin_pitch", "sin_pitch", "0", "1", "1", "-sin_pitch", "cos_pitch", "cos_pitch")
_SECOND = ("1", "sin_roll", "cos_roll", "0", "cos_roll", "-sin_roll", "1", "sin_roll", "cos_roll")
_FUNCTIONS = ("cos_roll", "cos_pitch", "sin_roll", "sin_pitch", "1")


class Tilt(nn.Module):
    """Rotation from base to heading frame, as footsel.footholds.pose.tilt_rotation, in float64 (Posture says why).

    planes: names of the input's, "roll" and "pitch" maybe among them; an angle without a plane is zero.
    """

    def __init__(self, planes: Sequence[str]) -> None:
        super().__init__()
        angles = np.zeros((len(planes), 2))
        for column, name in enumerate(("roll", "pitch")):
            if name in planes:
                angles[planes.index(name), column] = TILT_RANGE
        keep_constant(self, "angles", angles, np.float64)
        for name, factors in (("first", _FIRST), ("second", _SECOND)):
            weight = np.zeros((len(factors), len(_FUNCTIONS)))
            for entry, factor in enumerate(factors):
                if factor != "0":
                    weight[entry, _FUNCTIONS.index(factor.lstrip("-"))] = -1 if factor.startswith("-") else 1
            keep_constant(self, name, weight, np.float64)

    def forward(self, maps: Tensor) -> Tensor:
        """(n, planes, 40, 40) network input, whose tilt planes are the same all over -> (n, 3, 3)."""
        with own_precision():
            angles = maps[:, :, 0, 0].double() @ self.get_buffer("angles")
            functions = torch.cat([angles.cos(), angles.sin()], dim=1)
            first, second = (
                functional.linear(functions, weight[:, :4], weight[:, 4])
                for weight in (self.get_buffer("first"), self.get_buffer("second"))
            )
            return (first * second).reshape(-1, 3, 3)
