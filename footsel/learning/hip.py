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
from footsel.learning.posture import Posture
from footsel.learning.silhouette import seen_from_above, surface_points, underside
from footsel.learning.skeleton import LegSkeleton
from footsel.terrain import CELLS

#: Abductions at which it is looked up.
NODES = 15
#: Of the postures on flat ground at these shares of the height range, so many lie beyond the outermost, on either side.
DEPTHS, BEYOND = np.linspace(0.25, 0.9, 14), 0.05


class HipSweep(nn.Module):
    """Points on the surface of the bodies around the HFE axis, as the abduction turns them about the HAA axis.

    The thigh's pitch turns them too, but about their own axis or nearly so: they have the one in the middle. So a few
    postures per map stand for all, and each cell has a blend of the two next to its own.
    Ground above the hip point counts: walls meet the body on its side, where it is widest.
    """

    def __init__(self, layout: LegLayout, skeleton: LegSkeleton) -> None:
        super().__init__()
        (first, last), pitch = _usual(layout, skeleton)
        nodes = np.linspace(first, last, NODES)
        points = [_points(skeleton, tangent, pitch) for tangent in nodes]
        # As many for every posture: some twice.
        self._count = max(map(len, points))
        points = [np.resize(some, (self._count, 3)) for some in points]
        self.places = NODES * self._count
        keep_constant(self, "surface", np.concatenate(points).T, np.float64)
        keep_constant(self, "first", [[first]], np.float64)
        keep_constant(self, "nodes_per_unit", [[1 / (nodes[1] - nodes[0])]], np.float64)
        self._last = float(np.nextafter(np.float32(NODES - 1), np.float32(0)))

    def points(self, frame: Tensor) -> Tensor:
        """(n, 3, 3) of Tilt, in whatever units its rows are -> (n, 3, places) along these, posture after posture."""
        return frame @ self.get_buffer("surface")

    def blend(self, clearance: Tensor, posture: Tensor) -> Tensor:
        """(n, 1, places) of the points, (n, 10, 1600) of Posture -> (n, 1, 1600) the least of each cell's posture."""
        least = clearance.reshape(-1, NODES, self._count).amin(dim=2).unsqueeze(1)
        cosine, sine = posture[:, :1], posture[:, 1:2]
        at = ((_tangent(cosine, sine) - self.get_buffer("first")) * self.get_buffer("nodes_per_unit")).to(
            clearance.dtype
        )
        at = at.clamp(0.0, self._last)
        node = at.floor()
        index = node.long()
        near, change = (torch.gather(some, 2, index) for some in (least, least[..., 1:] - least[..., :-1]))
        return near + (at - node) * change


def _tangent(cosine: Tensor, sine: Tensor) -> Tensor:
    """Of half the angle: it grows with the angle all around."""
    return sine / (1 + cosine).clamp(min=0.1)


def _usual(layout: LegLayout, skeleton: LegSkeleton) -> tuple[NDArray[np.float64], float]:
    """(2,) from where to where the abduction goes, and the pitch in the middle, among postures that reach flat ground.

    As tangents of half the angles.
    """
    depth = torch.from_numpy(DEPTHS)[:, None, None].expand(-1, 1, CELLS**2)
    level = torch.eye(3, dtype=torch.float64).expand(len(DEPTHS), -1, -1)
    posture = Posture(layout, skeleton)(depth, level)
    planes = posture.movedim(1, 0)[:, posture[:, -1] > 0]
    abduction = _tangent(planes[0], planes[1])
    knee = torch.complex(planes[4], planes[5]) + 1j * torch.complex(planes[6], planes[7])
    thigh = knee * (skeleton.length / complex(*skeleton.thigh))
    pitch = _tangent(thigh.real, thigh.imag)
    return np.quantile(abduction.numpy(), [BEYOND, 1 - BEYOND]), float(np.median(pitch.numpy()))


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
