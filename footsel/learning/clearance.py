"""How high the leg passes over the terrain if its foot stands on a cell: what terrain collision depends on."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.learning.constants import keep_constant
from footsel.learning.hip import HipSweep
from footsel.learning.look_up import MIDDLE, LookUp
from footsel.learning.posture import TIMES_I, Posture
from footsel.learning.precision import own_precision
from footsel.learning.skeleton import LegSkeleton
from footsel.terrain import CELLS

#: A clearance counts up to this either way, in cells of the local map: 10 cm for ANYmal.
LARGEST_CLEARANCE = 5.0
#: Of what a ball does not touch, in [m].
FAR_BELOW = 10.0
#: Cells beyond a ball that still count, lower by FALL metres per metre: so a wall beside a body shows before it is
#: touched. Bodies have rims, and stand askew, where their balls end. Without the ring a small network takes ten times
#: as many colliding cells for feasible (docs/measure_clearance.py).
BEYOND, FALL = 1, 5.0


class LegClearance(nn.Module):
    """Clearance of each ball of the leg's skeleton over the terrain below it, in [-1, 1], 1 at LARGEST_CLEARANCE, and
    if so asked, of the body around the hip.

    The leg's posture puts the balls; each looks up the terrain's surface, grown by its radius and a margin aside. The
    balls fill the bodies roughly, so this is an estimate, which the network weighs. What it computes with is constant;
    `ball_fit` finds other constants by the gradient.

    beyond, fall: of spheres; a skeleton whose balls are fitted has its own rises. hip: whether there is a last channel,
    of HipSweep, which is looked up with the balls: an engine pays for operators.

    Sums that place the balls are in float64, for beside a wall little decides much. What follows goes number by number,
    which every engine rounds alike, in the input's type.
    """

    def __init__(
        self, layout: LegLayout, skeleton: LegSkeleton, beyond: int = BEYOND, fall: float = FALL, hip: bool = False
    ) -> None:
        super().__init__()
        self._balls = len(skeleton.radius)
        self.channels = self._balls + hip
        self.unit = LARGEST_CLEARANCE * layout.resolution
        self._to_unit = layout.height_range / self.unit
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
        keep_constant(self, "middle", [[MIDDLE], [MIDDLE], [0.0]], np.float64)
        # Ball after ball, in the surface of its radius.
        surface = np.array([radii.index(radius) for radius in skeleton.radius])
        places = np.repeat(surface, CELLS**2)
        self.hip = HipSweep(layout, skeleton) if hip else None
        if self.hip is not None:
            # In the ground itself, after these.
            places = np.append(places, np.full(self.hip.places, len(radii)))
        self._look_up = LookUp(places)

    def forward(
        self, posture: Tensor, tilt: Tensor, depth: Tensor, known: Tensor, above: Tensor | None = None
    ) -> Tensor:
        """(n, 10, 1600) of Posture, (n, 3, 3) of Tilt, (n, 1, 40, 40) depth and 1 where known -> (n, channels, 1600).

        above: (n, 1, 40, 40) by how much the ground rises above the hip point, in the depth's unit, for the hip.
        """
        with own_precision():
            # Unknown cells are as deep as an image goes: no leg comes near.
            ground = (1 - (1 - depth) * known) * -self._to_unit
            places, surfaces = self.centres(posture, tilt, depth.dtype), self._surfaces(ground)
            if self.hip is not None:
                assert above is not None
                points = self.hip.points(tilt * self.get_buffer("scale")) + self.get_buffer("middle")
                places = torch.cat([places, points.to(depth.dtype)], dim=2)
                surfaces = torch.cat([surfaces, ground + above * self._to_unit], dim=1)
            clearance = torch.clamp(places[:, 2:] - self._look_up(surfaces, places[:, :2]), -1, 1)
            if self.hip is None:
                return clearance.reshape(-1, self.channels, CELLS**2)
            balls, hip = torch.split(clearance, [self._balls * CELLS**2, self.hip.places], dim=2)
            return torch.cat([balls.reshape(-1, self._balls, CELLS**2), self.hip.blend(hip, posture)], dim=1)

    def centres(self, posture: Tensor, tilt: Tensor, dtype: torch.dtype = torch.float64) -> Tensor:
        """(n, 3, channels * 1600) of all balls in the heading frame, ball after ball, summed up in `dtype`.

        Row and column in cells from ORIGIN, and z in units of the largest clearance.
        """
        frame = (tilt @ self.get_buffer("leg_axes")) * self.get_buffer("scale")
        axes, origin = frame[..., :3], (frame[..., 3:] + self.get_buffer("middle")).to(dtype)
        # The map's axes go into the weights, which are few.
        place = (axes @ self.get_buffer("place")).reshape(-1, 3 * self._balls, Posture.CHANNELS)
        along_w = self.get_buffer("along_w").expand(axes.shape[0], -1, -1)
        sums = (torch.cat([place, axes @ self.get_buffer("w_axis"), along_w], dim=1) @ posture).to(dtype)
        place, w_axis, along_w = torch.split(sums, [3 * self._balls, 3, self._balls], dim=1)
        turned = along_w.unsqueeze(1) * w_axis.unsqueeze(2)
        return (place.reshape(turned.shape) + turned + origin.unsqueeze(3)).flatten(2)

    def _surfaces(self, ground: Tensor) -> Tensor:
        """(n, 1, 40, 40) ground -> (n, radii, 40, 40) how high the centre of a ball of each radius is that rests on it.

        In units of the largest clearance.
        """
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
