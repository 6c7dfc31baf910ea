"""How the leg is bent if its foot stands on a cell: what range, self-collision and margin depend on."""

import numpy as np
import torch
from torch import Tensor, nn

from footsel.learning.constants import keep_constant
from footsel.learning.float32 import float32
from footsel.learning.skeleton import LegSkeleton

#: Where the leg does not reach, roots and divisions go no further, in squares of its length: what they make of the last
#: bit would grow without bound. Feasible cells of ANYmal have 0.06 or more of `reach` and 0.0065 of `slack`.
LEAST_BELOW, LEAST_REACH, LEAST_SLACK = 1e-3, 1e-2, 6e-3

#: Complex numbers are pairs here, of numbers or of planes. This multiplies one by i.
TIMES_I = np.array([[0.0, -1.0], [1.0, 0.0]])


class Posture(nn.Module):
    """The leg's joints for a foot on every cell, without an angle: inverse kinematics in closed form.

    Lengths are shares of that of the stretched leg. The planes, complex numbers in pairs:
        abduction  the direction to which it turns the axis v, in the plane of v and w
        foot       in the leg plane, from the HFE axis, along u and w
        along      the knee's part in the direction of the foot
        across     the knee's part across it, turned back by a right angle: the knee is `along` + i `across`
        reach      square of the foot's distance from the HFE axis, which tells the knee's angle
        slack      square of the knee's distance from the line to the foot, by that to the foot; below 0 out of reach
    As footsel.robot.LegKinematics, which says what u, v and w are. Out of reach the leg is all but stretched, too
    near it is folded. Nothing here is learnt, so no gradient passes; computed in float32 even under autocast.
    A turn is a product of complex numbers, for an engine pays for operators more than for what they compute.
    """

    CHANNELS = 10

    def __init__(self, skeleton: LegSkeleton, height_range: float) -> None:
        super().__init__()
        self._leg = leg = skeleton
        length = leg.length
        # From Place's planes: the foot along u; in the plane of v and w, from the HAA axis, as a complex number z:
        # plane_offset z, -i z and z.
        along, z = leg.basis[:1], leg.basis[1:] / length
        axes = np.vstack([along / length, leg.plane_offset / length * z, -TIMES_I @ z, z])
        to_hfe = np.append(leg.hfe_offset[0] / length, np.zeros(6))
        keep_constant(self, "weight", height_range * axes)
        keep_constant(self, "bias", (-axes @ leg.haa - to_hfe)[:, None])

    @torch.no_grad()
    def forward(self, place: Tensor) -> Tensor:
        """(n, 3, 1600) of Place -> (n, 10, 1600)."""
        leg, length = self._leg, self._leg.length
        thigh, shank = float(leg.thigh @ leg.thigh) / length**2, float(leg.shank @ leg.shank) / length**2
        with float32():
            planes = self.get_buffer("weight") @ place + self.get_buffer("bias")
            along_u, kept, turning, z = planes[:, :1], planes[:, 1:3], planes[:, 3:5], planes[:, 5:]

            # The leg plane keeps its distance from the HAA axis: from zero it has turned by
            # (plane_offset - i down) z / |z|^2.
            offset = (leg.plane_offset / length) ** 2
            distance = (z * z).sum(dim=1, keepdim=True).clamp(min=offset + LEAST_BELOW)
            down = leg.below * (distance - offset).sqrt()
            abduction = (kept + turning * down) / distance

            # The knee lies on two circles, on the nominal stance's side.
            foot = torch.cat([along_u, down - float(leg.hfe_offset[1]) / length], dim=1)
            reach = (foot * foot).sum(dim=1, keepdim=True).clamp(min=LEAST_REACH)
            forward = 0.5 + (thigh - shank) / 2 / reach
            slack = thigh / reach - forward * forward
            aside = leg.knee_branch * slack.clamp(min=LEAST_SLACK).sqrt()
            return torch.cat([abduction, foot, forward * foot, aside * foot, reach, slack.clamp(-1, 1)], dim=1)
