"""How high the leg passes over the terrain if its foot stands on a cell: what terrain collision depends on."""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.footholds.encoding import TILT_RANGE
from footsel.learning.float32 import float32
from footsel.learning.skeleton import LegSkeleton
from footsel.terrain import CELLS

#: A clearance counts up to this either way, in cells of the local map: 10 cm for ANYmal.
LARGEST_CLEARANCE = 5.0
#: Depth that stands for unknown cells, which collide with nothing, in height ranges.
BOTTOMLESS = 3.0
#: Keeps roots and divisions finite where the leg does not reach, in [m^2].
TINY = 1e-6

Array = NDArray[np.float64]

#: Fields of three components each that the centre of every ball is a sum of: where HFE and KFE are, the unit vector v
#: turned by the abduction, u and w turned with the thigh and with the shank.
FIELDS = ("hfe", "kfe", "v", "u_thigh", "w_thigh", "u_shank", "w_shank")


class LegClearance(nn.Module):
    """Clearance of each ball of the leg's skeleton over the terrain below it, in [-1, 1], 1 at LARGEST_CLEARANCE.

    Inverse kinematics in closed form (footsel.robot.LegKinematics) gives the joints for a foot on each cell; the balls'
    centres are sums of vectors, one convolution; each looks up the terrain's surface, grown by its radius.
    The balls fill the bodies roughly, so this is an estimate, which the network weighs. Out of range the
    leg is stretched. Nothing here is learnt, so no gradient passes; computed in float32 even under autocast.
    """

    def __init__(self, layout: LegLayout, skeleton: LegSkeleton) -> None:
        super().__init__()
        self._layout, self._skeleton = layout, skeleton
        self.channels = len(skeleton.radius)
        self._radii = sorted(set(skeleton.radius.tolist()))
        weight = torch.zeros(3, self.channels, len(FIELDS), 3)
        for number, (link, ball) in enumerate(zip(skeleton.link, skeleton.balls, strict=True)):
            joint, u, w = (("hfe", "u_thigh", "w_thigh"), ("kfe", "u_shank", "w_shank"))[link]
            for field, length in zip((joint, u, "v", w), (1.0, *ball.tolist()), strict=True):
                weight[:, number, FIELDS.index(field)] += length * torch.eye(3)
        # x and y come out as indices of cells, z in metres.
        weight[:2] /= layout.resolution
        bias = torch.zeros(3, self.channels)
        bias[:2] = (CELLS - 1) / 2
        surface = torch.tensor([self._radii.index(radius) for radius in skeleton.radius.tolist()])
        self.register_buffer("weight", weight.reshape(3 * self.channels, -1, 1, 1), persistent=False)
        self.register_buffer("bias", bias.reshape(-1), persistent=False)
        self.register_buffer("surface", surface.float()[:, None, None] * CELLS**2, persistent=False)
        self.register_buffer("haa", _column(skeleton.haa), persistent=False)
        for name, axis in zip("uvw", skeleton.basis, strict=True):
            self.register_buffer(name, _column(axis), persistent=False)

    @torch.no_grad()
    def forward(self, place: Tensor, depth: Tensor, known: Tensor, roll: Tensor, pitch: Tensor) -> Tensor:
        """(n, 5, 40, 40) of Place, (n, 1, 40, 40) depth and 1 where it is known, (n, 1, 1, 1) tilt planes ->
        (n, channels, 40, 40)."""
        with float32():
            balls = self.centres(place, roll * TILT_RANGE, pitch * TILT_RANGE)
            at, height = balls[:, : 2 * self.channels].clamp(0, CELLS - 1), balls[:, 2 * self.channels :]
            below = self._look_up(self._surfaces(depth, known), at)
            clearance: Tensor = (height - below) / (LARGEST_CLEARANCE * self._layout.resolution)
            return clearance.clamp(-1, 1)

    def centres(self, place: Tensor, roll: Tensor, pitch: Tensor) -> Tensor:
        """(n, 3 channels, 40, 40) of all balls in the heading frame: rows, then columns, in cells, then z in [m].

        roll, pitch: (n, 1, 1, 1) in [rad].
        """
        leg = self._skeleton
        # (n, 3, 40, 40) foot's centre from the HAA axis, in base axes.
        foot = place[:, :3] * self._layout.height_range - self.get_buffer("haa")
        along, side, up = (_dot(axis, foot) for axis in leg.basis)

        # Abduction: the leg plane keeps its distance from the HAA axis.
        distance = (side * side + up * up).clamp(min=TINY)
        down = leg.below * (distance - leg.plane_offset**2).clamp(min=TINY).sqrt()
        cosine = (side * leg.plane_offset + up * down) / distance
        sine = (up * leg.plane_offset - side * down) / distance

        # The two links in the leg plane: the knee lies on two circles, on the nominal stance's side.
        foot_u, foot_w = along - float(leg.hfe_offset[0]), down - float(leg.hfe_offset[1])
        thigh, shank = float(leg.thigh @ leg.thigh), float(leg.shank @ leg.shank)
        reach = (foot_u * foot_u + foot_w * foot_w).clamp(min=TINY)
        forward = 0.5 + (thigh - shank) / 2 / reach
        aside = leg.knee_branch * (thigh / reach - forward * forward).clamp(min=0).sqrt()
        knee_u, knee_w = forward * foot_u - aside * foot_w, forward * foot_w + aside * foot_u

        # (n, 3, 1, 1) for the whole map, (n, 3, 40, 40) once the joints turn them; all in the heading frame.
        haa, u, v, w = (_tilted(self.get_buffer(name), roll, pitch) for name in ("haa", "u", "v", "w"))
        v, w = cosine * v + sine * w, cosine * w - sine * v
        u_thigh, w_thigh = _turned(u, w, leg.thigh, knee_u, knee_w, thigh)
        u_shank, w_shank = _turned(u, w, leg.shank, foot_u - knee_u, foot_w - knee_w, shank)
        hfe = haa + float(leg.hfe_offset[0]) * u + float(leg.hfe_offset[1]) * w
        kfe = hfe + knee_u * u + knee_w * w
        fields = torch.cat([hfe, kfe, v, u_thigh, w_thigh, u_shank, w_shank], dim=1)
        return functional.conv2d(fields, self.get_buffer("weight"), self.get_buffer("bias"))

    def _look_up(self, surfaces: Tensor, at: Tensor) -> Tensor:
        """(n, channels, 40, 40) of each ball's surface at (n, 2 channels, 40, 40) rows and columns.

        Bilinear, and so continuous: rounding decides nothing, and engines that round differently agree.
        """
        cell = at.floor().clamp(0, CELLS - 2)
        along, across = (at - cell).chunk(2, dim=1)
        row, column = cell.chunk(2, dim=1)
        index = (row * CELLS + column + self.get_buffer("surface")).long().flatten(1)
        # Values at the corner of four cells and differences from there, looked up in the same place.
        padded = functional.pad(surfaces, (0, 1, 0, 1))
        down, right = padded[:, :, 1:, :CELLS] - surfaces, padded[:, :, :CELLS, 1:] - surfaces
        twist = padded[:, :, 1:, 1:] - padded[:, :, :CELLS, 1:] - down
        corner, down, right, twist = (
            torch.gather(part.flatten(1), 1, index).reshape(along.shape) for part in (surfaces, down, right, twist)
        )
        return corner + along * down + across * (right + along * twist)

    def _surfaces(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, radii, 40, 40) how high the centre of a ball of each radius is that rests on the terrain, in [m]."""
        resolution, scale = self._layout.resolution, self._layout.height_range
        height = -scale * (depth * known + BOTTOMLESS * (1 - known))
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


def _column(vector: Array) -> Tensor:
    """(1, 3, 1, 1)."""
    return torch.from_numpy(vector).float()[None, :, None, None]


def _turned(u: Tensor, w: Tensor, link: Array, to_u: Tensor, to_w: Tensor, square: float) -> tuple[Tensor, Tensor]:
    """u and w, turned as the link (2,) is that now points to (to_u, to_w); square: of its length."""
    cosine = _dot(link / square, [to_u, to_w])
    sine = _dot(link[::-1] / square * np.array([1.0, -1.0]), [to_u, to_w])
    return cosine * u - sine * w, sine * u + cosine * w


def _tilted(vector: Tensor, roll: Tensor, pitch: Tensor) -> Tensor:
    """(1, 3, 1, 1) from base to heading frame, Ry(pitch) Rx(roll), as footsel.footholds.pose.tilt_rotation."""
    x, y, z = vector.unbind(dim=1)
    x, y, z = (part[:, None] for part in (x, y, z))
    cos_roll, sin_roll, cos_pitch, sin_pitch = roll.cos(), roll.sin(), pitch.cos(), pitch.sin()
    upward = sin_roll * y + cos_roll * z
    turned = [cos_pitch * x + sin_pitch * upward, cos_roll * y - sin_roll * z, cos_pitch * upward - sin_pitch * x]
    return torch.cat(turned, dim=1)


def _dot(numbers: Array, vector: Tensor | Sequence[Tensor]) -> Tensor:
    """Sum of the components (n, 1, h, w) of a vector weighted by constants; those that are zero cost nothing."""
    parts = vector.chunk(vector.shape[1], dim=1) if isinstance(vector, Tensor) else vector
    weighted = [(float(number), part) for number, part in zip(numbers, parts, strict=True) if number != 0]
    terms = [part if number == 1 else number * part for number, part in weighted]
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total
