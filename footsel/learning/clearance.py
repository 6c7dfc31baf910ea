"""How high the leg passes over the terrain if its foot stands on a cell: what terrain collision depends on."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.learning.constants import keep_constant
from footsel.learning.posture import TIMES_I, Posture
from footsel.learning.precision import own_precision
from footsel.learning.skeleton import LegSkeleton
from footsel.terrain import CELLS

#: A clearance counts up to this either way, in cells of the local map: 10 cm for ANYmal.
LARGEST_CLEARANCE = 5.0
#: Rows and columns are counted from this one, in the middle of the map, where float32 resolves them best. A look-up
#: goes from the first to just short of the last, which so is the second of two. [cells]
ORIGIN = CELLS // 2
FIRST, LAST = float(-ORIGIN), float(np.nextafter(np.float32(CELLS - 1 - ORIGIN), np.float32(0)))
#: Of what a ball does not touch, in [m].
FAR_BELOW = 10.0
#: Cells beyond a ball that still count, lower by FALL metres per metre: so a wall beside a body shows before it is
#: touched. Bodies have rims, and stand askew, where their balls end. Without the ring a small network takes ten times
#: as many colliding cells for feasible (docs/measure_clearance.py).
BEYOND, FALL = 1, 5.0


class LegClearance(nn.Module):
    """Clearance of each ball of the leg's skeleton over the terrain below it, in [-1, 1], 1 at LARGEST_CLEARANCE.

    The leg's posture puts the balls; each looks up the terrain's surface, grown by its radius and a margin aside. The
    balls fill the bodies roughly, so this is an estimate, which the network weighs. What it computes with is constant;
    `ball_fit` finds other constants by the gradient.

    beyond, fall: of spheres; a skeleton whose balls are fitted has its own rises.

    Sums that place the balls are in float64, for beside a wall little decides much. What follows goes number by number,
    which every engine rounds alike, in the input's type.
    """

    def __init__(self, layout: LegLayout, skeleton: LegSkeleton, beyond: int = BEYOND, fall: float = FALL) -> None:
        super().__init__()
        self._layout = layout
        self.channels = len(skeleton.radius)
        self.unit = LARGEST_CLEARANCE * layout.resolution
        radii = sorted(set(skeleton.radius.tolist()))
        rises = skeleton.rises
        if rises is None:
            rises = _rises(np.array(radii), layout.resolution, beyond, fall)
        keep_constant(self, "rises", rises[..., None, None] / self.unit)
        for name, weight in zip(("place", "along_w", "w_axis"), ball_sums(skeleton), strict=True):
            keep_constant(self, name, weight, np.float64)

        # From the leg's axes to the map: rows and columns, and heights.
        to_hfe = skeleton.haa + skeleton.basis[0] * skeleton.hfe_offset[0]
        keep_constant(self, "leg_axes", np.column_stack([skeleton.basis.T, to_hfe]), np.float64)
        scale = [[1 / layout.resolution], [1 / layout.resolution], [1 / self.unit]]
        keep_constant(self, "scale", scale, np.float64)
        middle = (CELLS - 1) / 2 - ORIGIN
        keep_constant(self, "middle", [[middle], [middle], [0.0]], np.float64)
        # Ball after ball, where its radius's surface begins.
        surface = np.array([radii.index(radius) for radius in skeleton.radius])
        keep_constant(self, "index", np.array([[float(CELLS), 1.0]]))
        keep_constant(self, "first_index", np.repeat(surface * CELLS**2 + ORIGIN * (CELLS + 1), CELLS**2)[None])

    def forward(self, posture: Tensor, tilt: Tensor, depth: Tensor, known: Tensor) -> Tensor:
        """(n, 10, 1600) of Posture, (n, 3, 3) of Tilt, (n, 1, 40, 40) depth and 1 where it is known ->
        (n, channels, 1600)."""
        with own_precision():
            centres = self.centres(posture, tilt, depth.dtype)
            clearance = centres[:, 2:] - self._look_up(self._surfaces(depth, known), centres[:, :2])
            return clearance.clamp(-1, 1).reshape(-1, self.channels, CELLS**2)

    def centres(self, posture: Tensor, tilt: Tensor, dtype: torch.dtype = torch.float64) -> Tensor:
        """(n, 3, channels * 1600) of all balls in the heading frame, ball after ball, summed up in `dtype`.

        Row and column in cells from ORIGIN, and z in units of the largest clearance.
        """
        frame = (tilt @ self.get_buffer("leg_axes")) * self.get_buffer("scale")
        axes, origin = frame[..., :3], (frame[..., 3:] + self.get_buffer("middle")).to(dtype)
        # The map's axes go into the weights, which are few.
        place = (axes @ self.get_buffer("place")).reshape(-1, 3 * self.channels, Posture.CHANNELS)
        along_w = self.get_buffer("along_w").expand(axes.shape[0], -1, -1)
        sums = (torch.cat([place, axes @ self.get_buffer("w_axis"), along_w], dim=1) @ posture).to(dtype)
        place, w_axis, along_w = torch.split(sums, [3 * self.channels, 3, self.channels], dim=1)
        turned = along_w.unsqueeze(1) * w_axis.unsqueeze(2)
        return (place.reshape(turned.shape) + turned + origin.unsqueeze(3)).flatten(2)

    def _look_up(self, surfaces: Tensor, at: Tensor) -> Tensor:
        """(n, 1, channels * 1600) of each ball's surface at (n, 2, channels * 1600) rows and columns.

        Bilinear, and so continuous: rounding decides nothing, and engines that round differently agree.
        """
        at = at.clamp(FIRST, LAST)
        # The cell whose corner is the least of four; surfaces lie one after the other.
        corner = at.floor()
        along, across = (at - corner).chunk(2, dim=1)
        index = (self.get_buffer("index") @ corner + self.get_buffer("first_index")).long()
        # Values there, and by how much they change over a row, over a column and over both.
        values = surfaces.reshape(-1, 1, surfaces.shape[1] * CELLS**2)
        down, right = values[..., CELLS:] - values[..., :-CELLS], values[..., 1:] - values[..., :-1]
        twist = down[..., 1:] - down[..., :-1]
        value, down, right, twist = (torch.gather(part, 2, index) for part in (values, down, right, twist))
        return value + along * down + across * (right + along * twist)

    def _surfaces(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, radii, 40, 40) how high the centre of a ball of each radius is that rests on the terrain.

        In units of the largest clearance. Unknown cells are as deep as an image goes: no leg comes near.
        """
        depth = 1 - (1 - depth) * known
        ground = depth * (-self._layout.height_range / self.unit)
        # Of each square around a cell, from that of the one before.
        highest = [ground]
        while len(highest) < self.get_buffer("rises").shape[1]:
            highest.append(functional.max_pool2d(highest[-1], 3, stride=1, padding=1))
        return (torch.cat(highest, dim=1).unsqueeze(1) + self.get_buffer("rises")).amax(dim=2)


def ball_sums(leg: LegSkeleton) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Sums of Posture's 10 planes, in [m], that place m balls from the HFE axis: the first + the second x the third.

    (3, 10 m) along u, v and w but for what turns with the leg plane's w, ball after ball; (m, 10) along that w;
    (3, 10) where it points.
    """
    # Pairs of planes: abduction, foot, along, across; then reach and slack.
    pairs = np.eye(Posture.CHANNELS).reshape(5, 2, Posture.CHANNELS)
    abduction, foot, along, across, _ = pairs
    knee = along + TIMES_I @ across
    w_axis = np.vstack([np.zeros(Posture.CHANNELS), TIMES_I @ abduction])
    place, along_w = np.zeros((3, len(leg.radius), Posture.CHANNELS)), np.zeros((len(leg.radius), Posture.CHANNELS))
    for number, (link, (ball_u, ball_v, ball_w)) in enumerate(zip(leg.link, leg.balls, strict=True)):
        ball = np.array([ball_u, ball_w])
        centre = _times(ball, leg.thigh) @ knee if link == 0 else knee + _times(ball, leg.shank) @ (foot - knee)
        place[0, number], along_w[number] = leg.length * centre
        place[1:, number] = ball_v * abduction
        place[:, number] += leg.hfe_offset[1] * w_axis
    return place.reshape(3, -1), along_w, w_axis


def _rises(radii: NDArray[np.float64], resolution: float, beyond: int, fall: float) -> NDArray[np.float64]:
    """(radii, rings) how far the centre of a ball lies above the cells of a square ring that it touches, in [m].

    Below them for `beyond` rings more, far below for those after.
    """
    reached = np.ceil(radii / resolution - 1e-9).astype(int)[:, None]
    rings = np.arange(reached.max() + beyond)
    aside, radii = rings * resolution, radii[:, None]
    touching = np.sqrt(np.maximum(radii**2 - aside**2, 0))
    beside = np.where(rings < reached + beyond, fall * (radii - aside), -FAR_BELOW)
    return np.where(rings < reached, touching, beside)


def _times(dividend: NDArray[np.float64], divisor: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, 2) that multiplies a complex number by the quotient of two others, (2,) each."""
    quotient = complex(*dividend) / complex(*divisor)
    return quotient.real * np.eye(2) + quotient.imag * TIMES_I
