"""Where a foot on each cell would stand, seen from the base: range, self-collision and margin depend on that alone."""

import torch
from torch import Tensor, nn

from footsel.footholds import LegLayout
from footsel.footholds.encoding import TILT_RANGE
from footsel.learning.float32 import float32
from footsel.terrain import CELLS
from footsel.terrain.local_map import cell_offsets


class Place(nn.Module):
    """Foot centres in base axes, from the leg's hip point, as shares of the height range.

    The inverse of footsel.footholds.pose.tilt_rotation, computed in float32 even under autocast: 2 mm matter at the
    border of the range. Outputs x, y, z, then x and y in the heading frame, which terrain keeps to.
    """

    CHANNELS = 5

    def __init__(self, layout: LegLayout) -> None:
        super().__init__()
        self._foot_radius = layout.foot_radius / layout.height_range
        offsets = torch.from_numpy(cell_offsets(CELLS, layout.resolution) / layout.height_range).float()
        self.register_buffer("x", offsets[None, None, :, :, 0].contiguous(), persistent=False)
        self.register_buffer("y", offsets[None, None, :, :, 1].contiguous(), persistent=False)

    def forward(self, depth: Tensor, roll: Tensor, pitch: Tensor) -> Tensor:
        """(n, 1, 40, 40) depth, (n, 1, 1, 1) tilt planes in [-1, 1] -> (n, 5, 40, 40)."""
        with float32():
            x, y, z = self.get_buffer("x"), self.get_buffer("y"), self._foot_radius - depth
            cos_roll, sin_roll = torch.cos(roll * TILT_RANGE), torch.sin(roll * TILT_RANGE)
            cos_pitch, sin_pitch = torch.cos(pitch * TILT_RANGE), torch.sin(pitch * TILT_RANGE)
            # Pitch is undone first, then roll.
            forward = cos_pitch * x - sin_pitch * z
            upward = sin_pitch * x + cos_pitch * z
            base = [forward, cos_roll * y + sin_roll * upward, cos_roll * upward - sin_roll * y]
            return torch.cat([*base, x.expand_as(depth), y.expand_as(depth)], dim=1)
