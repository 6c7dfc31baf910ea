"""The body around the hip, which may decide whether any foothold is left.

Around the HFE axis a leg is thick and short, and it hardly moves there: if a wall touches it, no foothold of the map is
free. So what is told wrongly of it is wrong for a whole map.
"""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from footsel.footholds import LegLayout
from footsel.learning.constants import keep_constant
from footsel.learning.posture import TIMES_I, Posture
from footsel.learning.silhouette import seen_from_above, surface_points, underside
from footsel.learning.skeleton import LegSkeleton
from footsel.terrain import CELLS

#: Abductions at which it is looked up, each at so many pitches of the thigh.
NODES, PITCHES = 7, 2
#: Of the postures on flat ground at these shares of the height range, so many lie beyond the outermost, on either side.
DEPTHS, BEYOND = np.linspace(0.25, 0.9, 14), 0.05


class HipSweep(nn.Module):
    """Points on the surface of the bodies around the HFE axis, as the abduction turns them about the HAA axis.

    The thigh's pitch turns them about their own axis or nearly so, for which two pitches do. So a few postures per map
    stand for all, and each cell has a blend of the four around its own.
    Ground above the hip point counts: walls meet the body on its side, where it is widest.
    """

    def __init__(self, layout: LegLayout, skeleton: LegSkeleton) -> None:
        super().__init__()
        (first, last), (backward, forward) = _usual(layout, skeleton)
        abductions, pitches = np.linspace(first, last, NODES), np.linspace(backward, forward, PITCHES)
        points = [_points(skeleton, abduction, pitch) for pitch in pitches for abduction in abductions]
        # As many for every posture: some twice.
        self._count = max(map(len, points))
        points = [np.resize(some, (self._count, 3)) for some in points]
        self.places = PITCHES * NODES * self._count
        keep_constant(self, "surface", np.concatenate(points).T, np.float64)
        keep_constant(self, "turns", turns(skeleton), np.float64)
        keep_constant(self, "first", [[abductions[0]], [pitches[0]]], np.float64)
        steps = [[abductions[1] - abductions[0]], [pitches[1] - pitches[0]]]
        keep_constant(self, "nodes_per_unit", np.reciprocal(steps), np.float64)
        self._last = float(np.nextafter(np.float32(NODES - 1), np.float32(0)))

    def points(self, frame: Tensor) -> Tensor:
        """(n, 3, 3) of Tilt, in whatever units its rows are -> (n, 3, places) along these, posture after posture."""
        return frame @ self.get_buffer("surface")

    def blend(self, clearance: Tensor, posture: Tensor) -> Tensor:
        """(n, 1, places) of the points, (n, 10, 1600) of Posture -> (n, 1, 1600) the least, of each cell's posture."""
        least = clearance.reshape(-1, PITCHES, NODES, self._count).amin(dim=3)
        at = (_tangent(self.get_buffer("turns") @ posture) - self.get_buffer("first")) * self.get_buffer(
            "nodes_per_unit"
        )
        abduction, pitch = at.to(clearance.dtype).clamp(0.0, self._last).chunk(2, dim=1)
        node = abduction.floor()
        index = node.long().expand(-1, PITCHES, -1)
        near, change = (torch.gather(some, 2, index) for some in (least, least[..., 1:] - least[..., :-1]))
        backward, forward = (near + (abduction - node) * change).chunk(2, dim=1)
        return backward + pitch.clamp(max=1.0) * (forward - backward)


def turns(skeleton: LegSkeleton) -> NDArray[np.float64]:
    """(4, 10) sums of Posture's planes: cosines of the abduction and of the thigh's pitch, then their sines."""
    abduction, _, along, across, _ = np.eye(Posture.CHANNELS).reshape(5, 2, Posture.CHANNELS)
    knee = along + TIMES_I @ across
    u, w = skeleton.thigh
    # The thigh at zero angles points along (u, w), and so the knee's direction is divided by that.
    thigh = np.array([[u, w], [-w, u]]) @ knee * (skeleton.length / (u * u + w * w))
    together: NDArray[np.float64] = np.stack([abduction, thigh], axis=1).reshape(4, Posture.CHANNELS)
    return together


def _tangent(turns: Tensor) -> Tensor:
    """(n, 4, 1600) of `turns` -> (n, 2, 1600) tangents of half the angles: they grow with an angle all around."""
    cosine, sine = turns.chunk(2, dim=1)
    return sine / (1 + cosine).clamp(min=0.1)


def _usual(layout: LegLayout, skeleton: LegSkeleton) -> NDArray[np.float64]:
    """(2, 2) from where to where the abduction and the thigh's pitch go among postures that reach flat ground.

    As tangents of half the angles.
    """
    depth = torch.from_numpy(DEPTHS)[:, None, None].expand(-1, 1, CELLS**2)
    level = torch.eye(3, dtype=torch.float64).expand(len(DEPTHS), -1, -1)
    posture = Posture(layout, skeleton)(depth, level)
    tangents = _tangent(torch.from_numpy(turns(skeleton)) @ posture).movedim(1, 0)[:, posture[:, -1] > 0]
    ends: NDArray[np.float64] = np.quantile(tangents.numpy(), [BEYOND, 1 - BEYOND], axis=1).T
    return ends


def _points(skeleton: LegSkeleton, abduction: float, pitch: float) -> NDArray[np.float64]:
    """(m, 3) points on the bodies around the hip, in base axes from the hip point, in [m].

    abduction, pitch: tangents of half the angles.
    """
    # The axis itself, for a leg without any.
    found = [(skeleton.haa + np.append(skeleton.hfe_offset[0], np.zeros(2)) @ skeleton.basis)[None]]
    turn, swing = (complex(1, tangent) ** 2 / (1 + tangent**2) for tangent in (abduction, pitch))
    for row in skeleton.hip if skeleton.hip is not None else ():
        u, v, w = surface_points(row).T
        thigh = (u + 1j * w) * swing
        across = (v + 1j * (skeleton.hfe_offset[1] + thigh.imag)) * turn
        local = np.column_stack([skeleton.hfe_offset[0] + thigh.real, across.real, across.imag])
        surface = skeleton.haa + local @ skeleton.basis
        outline = seen_from_above(surface)
        found += [outline, underside(surface, outline)]
    return np.concatenate(found)
