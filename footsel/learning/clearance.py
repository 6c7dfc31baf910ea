"""How high the leg passes over the terrain if its foot stands on a cell: what terrain collision depends on."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.learning.float32 import float32
from footsel.learning.place import Place
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import turned
from footsel.terrain import CELLS

#: A clearance counts up to this either way, in cells of the local map: 10 cm for ANYmal.
LARGEST_CLEARANCE = 5.0
#: Keeps roots and divisions finite where the leg does not reach, in [m^2].
TINY = 1e-6

#: Complex numbers are pairs here, of numbers or of planes. This multiplies one by i.
TIMES_I = np.array([[0.0, -1.0], [1.0, 0.0]])


class LegClearance(nn.Module):
    """Clearance of each ball of the leg's skeleton over the terrain below it, in [-1, 1], 1 at LARGEST_CLEARANCE.

    Inverse kinematics in closed form (footsel.robot.LegKinematics) puts the balls where a foot on each cell puts the
    leg; each looks up the terrain's surface, grown by its radius. The balls fill the bodies roughly, so this is an
    estimate, which the network weighs. Out of range the leg is stretched. Nothing here is learnt, so no gradient
    passes; computed in float32 even under autocast.

    No angle is ever computed: a turn in a plane is a product of complex numbers, and where the turns are constant, all
    of them are one convolution. An engine pays for operators more than for what they compute.
    """

    def __init__(self, layout: LegLayout, skeleton: LegSkeleton) -> None:
        super().__init__()
        self._layout, self._skeleton = layout, skeleton
        leg = skeleton
        self.channels = len(leg.radius)
        self._radii = sorted(set(leg.radius.tolist()))

        # The foot from Place's planes: along u from the HFE axis; in the plane of v and w from the HAA axis, as a
        # complex number z; what `centres` needs of it is plane_offset (z, i z), then (-i z, z).
        along, z = leg.basis[:1], leg.basis[1:]
        axes = np.vstack([along, leg.plane_offset * z, leg.plane_offset * TIMES_I @ z, -TIMES_I @ z, z])
        to_hfe = np.zeros(len(axes))
        to_hfe[0] = leg.hfe_offset[0]
        unseen = np.zeros((len(axes), Place.CHANNELS - 3))
        self._keep("foot_axes", np.hstack([layout.height_range * axes, unseen])[..., None, None])
        self._keep("foot_offset", -axes @ leg.haa - to_hfe)

        # The balls in the leg plane, complex numbers along u and w, are sums of constant multiples of three: the foot
        # f from the HFE axis, and the two whose sum, the second times i, is the knee.
        knee, foot = np.hstack([np.zeros((2, 2)), np.eye(2), TIMES_I]), np.eye(2, 6)
        balls = np.empty((2, self.channels, 6))
        for number, (link, ball) in enumerate(zip(leg.link, leg.balls[:, ::2], strict=True)):
            balls[:, number] = (
                _times(ball, leg.thigh) @ knee if link == 0 else knee + _times(ball, leg.shank) @ (foot - knee)
            )
        self._keep("in_plane", balls.reshape(-1, 6)[..., None, None])
        self._keep("hfe", np.repeat(leg.hfe_offset, self.channels))
        self._keep("beside", leg.balls[:, 1].reshape(-1, 1, 1))

        # From the leg's axes to the map: rows and columns, and heights in [m].
        self._keep("leg_axes", np.column_stack([leg.basis.T, leg.haa]))
        self._keep("scale", np.array([[1 / layout.resolution], [1 / layout.resolution], [1.0]]))
        self._keep("middle", np.array([[(CELLS - 1) / 2], [(CELLS - 1) / 2], [0.0]]))
        surface = np.array([self._radii.index(radius) for radius in leg.radius])
        self._keep("surface", surface.reshape(-1, 1, 1) * CELLS**2)

    @torch.no_grad()
    def forward(self, place: Tensor, depth: Tensor, known: Tensor, tilt: Tensor) -> Tensor:
        """(n, 5, 40, 40) of Place, (n, 1, 40, 40) depth and 1 where it is known, (n, 3, 3) tilt_matrix ->
        (n, channels, 40, 40)."""
        with float32():
            row, column, height = (part.squeeze(1) for part in self.centres(place, tilt).chunk(3, dim=1))
            below = self._look_up(self._surfaces(depth, known), row.clamp(0, CELLS - 1), column.clamp(0, CELLS - 1))
            clearance: Tensor = (height - below) / (LARGEST_CLEARANCE * self._layout.resolution)
            return clearance.clamp(-1, 1)

    def centres(self, place: Tensor, tilt: Tensor) -> Tensor:
        """(n, 3, channels, 40, 40) of all balls in the heading frame: row and column in cells, and z in [m]."""
        leg = self._skeleton
        planes = functional.conv2d(place, self.get_buffer("foot_axes"), self.get_buffer("foot_offset"))
        along, kept, turning = planes[:, :1], planes[:, 1:5], planes[:, 5:]

        # Abduction: the leg plane keeps its distance from the HAA axis. From zero it has turned by
        # (plane_offset - i down) z / |z|^2.
        across = turning[:, 2:]
        distance = (across * across).sum(dim=1, keepdim=True).clamp(min=TINY)
        down = leg.below * (distance - leg.plane_offset**2).clamp(min=TINY).sqrt()
        turn, turn_times_i = ((kept + turning * down) / distance).unsqueeze(2).chunk(2, dim=1)

        # The two links in the leg plane: the knee lies on two circles, on the nominal stance's side.
        foot = torch.cat([along, down - float(leg.hfe_offset[1])], dim=1)
        thigh, shank = float(leg.thigh @ leg.thigh), float(leg.shank @ leg.shank)
        reach = (foot * foot).sum(dim=1, keepdim=True).clamp(min=TINY)
        forward = 0.5 + (thigh - shank) / 2 / reach
        aside = leg.knee_branch * (thigh / reach - forward * forward).clamp(min=0).sqrt()
        parts = torch.cat([foot, forward * foot, aside * foot], dim=1)
        balls = functional.conv2d(parts, self.get_buffer("in_plane"), self.get_buffer("hfe"))
        u, w = balls.unsqueeze(1).chunk(2, dim=2)

        # Out of the leg plane and into the map.
        vw = self.get_buffer("beside") * turn + w * turn_times_i
        frame = (tilt @ self.get_buffer("leg_axes")) * self.get_buffer("scale")
        axes, haa = frame[..., :3], frame[..., 3:]
        centres: Tensor = turned(axes, torch.cat([u, vw], dim=1)) + (haa + self.get_buffer("middle"))[..., None, None]
        return centres

    def _look_up(self, surfaces: Tensor, row: Tensor, column: Tensor) -> Tensor:
        """(n, channels, 40, 40) of each ball's surface at rows and columns of the same shape.

        Bilinear, and so continuous: rounding decides nothing, and engines that round differently agree.
        """
        # The cell whose corner is the least of four; surfaces lie one after the other.
        corner_row, corner_column = row.floor().clamp(0, CELLS - 2), column.floor().clamp(0, CELLS - 2)
        along, across = row - corner_row, column - corner_column
        index = (corner_row * CELLS + corner_column + self.get_buffer("surface")).long().flatten(1)
        # Values there, and by how much they change over a row, over a column and over both.
        values = surfaces.flatten(1)
        down, right = values[:, CELLS:] - values[:, :-CELLS], values[:, 1:] - values[:, :-1]
        twist = down[:, 1:] - down[:, :-1]
        value, down, right, twist = (torch.gather(part, 1, index).view_as(row) for part in (values, down, right, twist))
        return value + along * down + across * (right + along * twist)

    def _surfaces(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, radii, 40, 40) how high the centre of a ball of each radius is that rests on the terrain, in [m].

        Unknown cells are as deep as an image goes: no leg comes near.
        """
        resolution = self._layout.resolution
        height = -self._layout.height_range * (depth * known + (1 - known))
        rings = int(np.ceil(self._radii[-1] / resolution - 1e-9))
        highest = [functional.max_pool2d(height, 2 * ring + 1, stride=1, padding=ring) for ring in range(1, rings)]
        surfaces = []
        for radius in self._radii:
            surface = height + radius
            for ring, ground in enumerate(highest, start=1):
                if ring * resolution < radius - 1e-9:
                    surface = torch.maximum(surface, ground + float(np.sqrt(radius**2 - (ring * resolution) ** 2)))
            surfaces.append(surface)
        return torch.cat(surfaces, dim=1)

    def _keep(self, name: str, value: NDArray[np.float64]) -> None:
        """A constant that goes where the layer goes, but not into files."""
        self.register_buffer(name, torch.from_numpy(value).float(), persistent=False)


def _times(dividend: NDArray[np.float64], divisor: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, 2) that multiplies a complex number by the quotient of two others, (2,) each."""
    quotient = complex(*dividend) / complex(*divisor)
    return quotient.real * np.eye(2) + quotient.imag * TIMES_I
