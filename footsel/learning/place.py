"""Where a foot on each cell would stand, seen from the base: range, self-collision and margin depend on that alone."""

import numpy as np
import torch
from torch import Tensor, nn

from footsel.footholds import LegLayout
from footsel.learning.constants import keep_constant
from footsel.learning.precision import own_precision
from footsel.terrain import CELLS
from footsel.terrain.local_map import cell_offsets


class Place(nn.Module):
    """Foot centres in base axes, from the leg's hip point, as shares of the height range: a frame times points.

    In float64, as Posture, which says why.
    """

    CHANNELS = 3

    def __init__(self, layout: LegLayout) -> None:
        super().__init__()
        # Rows of a point in the heading frame: x, y and 1; its depth comes last.
        known = np.ones((3, CELLS**2))
        known[:2] = cell_offsets(CELLS, layout.resolution).reshape(-1, 2).T / layout.height_range
        keep_constant(self, "known", known[None], np.float64)
        centre = np.zeros((3, 4))
        centre[[0, 1], [0, 1]] = 1
        centre[2, 2:] = layout.foot_radius / layout.height_range, -1
        keep_constant(self, "centre", centre, np.float64)

    def points(self, depth: Tensor) -> Tensor:
        """(n, 1, 1600) depth -> (n, 4, 1600)."""
        return torch.cat([self.get_buffer("known").expand(depth.shape[0], -1, -1), depth.double()], dim=1)

    def frame(self, tilt: Tensor) -> Tensor:
        """(n, 3, 3) of Tilt -> (n, 3, 4) that takes such points to the feet's centres."""
        with own_precision():
            return tilt.mT @ self.get_buffer("centre")

    def forward(self, depth: Tensor, tilt: Tensor) -> Tensor:
        """(n, 1, 1600) depth, (n, 3, 3) of Tilt -> (n, 3, 1600)."""
        with own_precision():
            return self.frame(tilt) @ self.points(depth)
