"""Where a foot on each cell would stand, seen from the base: range, self-collision and margin depend on that alone."""

import torch
from torch import Tensor, nn

from footsel.footholds import LegLayout
from footsel.learning.float32 import float32
from footsel.learning.tilt import turned
from footsel.terrain import CELLS
from footsel.terrain.local_map import cell_offsets


class Place(nn.Module):
    """Foot centres in base axes, from the leg's hip point, as shares of the height range.

    Computed in float32 even under autocast: 2 mm matter at the border of the range. Outputs x, y, z, then x and y in
    the heading frame, which terrain keeps to.
    """

    CHANNELS = 5

    def __init__(self, layout: LegLayout) -> None:
        super().__init__()
        self._foot_radius = layout.foot_radius / layout.height_range
        offsets = torch.from_numpy(cell_offsets(CELLS, layout.resolution) / layout.height_range).float()
        self.register_buffer("xy", offsets.permute(2, 0, 1)[None].contiguous(), persistent=False)
        self.register_buffer("heading_xy", torch.eye(3)[None, :2], persistent=False)

    def forward(self, depth: Tensor, tilt: Tensor) -> Tensor:
        """(n, 1, 40, 40) depth, (n, 3, 3) footsel.learning.tilt.tilt_matrix -> (n, 5, 40, 40)."""
        with float32():
            xy = self.get_buffer("xy").expand(depth.shape[0], -1, -1, -1)
            heading_xy = self.get_buffer("heading_xy").expand(depth.shape[0], -1, -1)
            feet = torch.cat([xy, self._foot_radius - depth], dim=1)  # (n, 3, 40, 40) in the heading frame
            return turned(torch.cat([tilt.mT, heading_xy], dim=1), feet)
