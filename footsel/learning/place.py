"""Where a foot on each cell would stand, seen from the base: range, self-collision and margin depend on that alone."""

import numpy as np
from torch import Tensor, nn

from footsel.footholds import LegLayout
from footsel.learning.constants import keep_constant
from footsel.learning.float32 import float32
from footsel.terrain import CELLS
from footsel.terrain.local_map import cell_offsets


class Place(nn.Module):
    """Foot centres in base axes, from the leg's hip point, as shares of the height range.

    Computed in float32 even under autocast: 2 mm matter at the border of the range.
    """

    CHANNELS = 3

    def __init__(self, layout: LegLayout) -> None:
        super().__init__()
        # Feet at the depth 0 in the heading frame; depth takes them down.
        feet = np.empty((3, CELLS**2))
        feet[:2] = cell_offsets(CELLS, layout.resolution).reshape(-1, 2).T / layout.height_range
        feet[2] = layout.foot_radius / layout.height_range
        keep_constant(self, "feet", feet)
        keep_constant(self, "down", [[0.0], [0.0], [-1.0]])

    def forward(self, depth: Tensor, tilt: Tensor) -> Tensor:
        """(n, 1, 1600) depth, (n, 3, 3) footsel.learning.tilt -> (n, 3, 1600)."""
        with float32():
            return tilt.mT @ (self.get_buffer("feet") + depth * self.get_buffer("down"))
