"""How the leg is bent if its foot stands on a cell: what range, self-collision and margin depend on."""

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor, nn

from footsel.footholds import LegLayout
from footsel.learning.constants import keep_constant
from footsel.learning.place import Place
from footsel.learning.precision import own_precision
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
    near it is folded. Nothing here is learnt, so no gradient passes.
    In float64: at the border of the range a network tells half a millimetre apart, and there what float32 rounds off a
    foot's place would be worth 1e-3 of a logit, another in every engine.
    A turn is a product of complex numbers, for an engine pays for operators more than for what they compute.
    """

    CHANNELS = 10

    def __init__(self, layout: LegLayout, skeleton: LegSkeleton) -> None:
        super().__init__()
        self._place = Place(layout)
        self._leg = leg = skeleton
        length = leg.length
        # From a foot's centre: the foot along u; in the plane of v and w, from the HAA axis, as a complex number z:
        # plane_offset z, -i z and z.
        along, z = leg.basis[:1], leg.basis[1:] / length
        axes = np.vstack([along / length, leg.plane_offset / length * z, -TIMES_I @ z, z])
        self._keep("axes", layout.height_range * axes)
        # The third number of Place's points is 1.
        to_hfe = np.append(leg.hfe_offset[0] / length, np.zeros(6))
        self._keep("shift", np.outer(-axes @ leg.haa - to_hfe, [0, 0, 1, 0]))
        offset, thigh, shank = leg.plane_offset / length, leg.thigh / length, leg.shank / length
        self._keep("offset", offset**2)
        self._keep("hfe_w", leg.hfe_offset[1] / length)
        self._keep("thigh", thigh @ thigh)
        self._keep("difference", (thigh @ thigh - shank @ shank) / 2)
        for name, least in (("least_below", LEAST_BELOW), ("least_reach", LEAST_REACH), ("least_slack", LEAST_SLACK)):
            self._keep(name, least)

    def _keep(self, name: str, value: ArrayLike) -> None:
        # Also single numbers: an exporter rounds those of Python to float32.
        keep_constant(self, name, value, np.float64)

    @torch.no_grad()
    def forward(self, depth: Tensor, tilt: Tensor) -> Tensor:
        """(n, 1, 1600) depth, (n, 3, 3) of Tilt -> (n, 10, 1600)."""
        leg, offset = self._leg, self.get_buffer("offset")
        with own_precision():
            frame = self.get_buffer("axes") @ self._place.frame(tilt) + self.get_buffer("shift")
            planes = frame @ self._place.points(depth)
            along_u, kept, turning, z = planes[:, :1], planes[:, 1:3], planes[:, 3:5], planes[:, 5:]

            # The leg plane keeps its distance from the HAA axis: from zero it has turned by
            # (plane_offset - i down) z / |z|^2.
            beyond = torch.maximum((z * z).sum(dim=1, keepdim=True) - offset, self.get_buffer("least_below"))
            down = leg.below * beyond.sqrt()
            abduction = (kept + turning * down) / (beyond + offset)

            # The knee lies on two circles, on the nominal stance's side.
            foot = torch.cat([along_u, down - self.get_buffer("hfe_w")], dim=1)
            reach = torch.maximum((foot * foot).sum(dim=1, keepdim=True), self.get_buffer("least_reach"))
            forward = 0.5 + self.get_buffer("difference") / reach
            slack = self.get_buffer("thigh") / reach - forward * forward
            aside = leg.knee_branch * torch.maximum(slack, self.get_buffer("least_slack")).sqrt()
            return torch.cat([abduction, foot, forward * foot, aside * foot, reach, slack.clamp(-1, 1)], dim=1)
