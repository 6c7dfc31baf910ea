"""How high the ground is where a leg passes over it: what terrain collision turns on.

Which points a leg passes over on its way from the foot to the hip depends on the foot's place alone. The network learns
them, one set per cell, beginning with the straight line; the ground is looked up there, between cells.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.learning.float32 import float32
from footsel.learning.place import Place
from footsel.learning.relief import LARGEST_RISE
from footsel.terrain import CELLS

#: Points per leg, and channels of the layer that places them.
POINTS, HIDDEN = 6, 16
#: How far an output of one moves a point, as a share of half the map: a few cells.
STEP = 0.2


class AlongLeg(nn.Module):
    """Height of the ground over that of the foot at POINTS points, as a share of LARGEST_RISE.

    A leg is as thick as three cells, so the highest of 3x3 counts. Computed in float32 even under autocast.
    """

    CHANNELS = POINTS

    def __init__(self, layout: LegLayout) -> None:
        super().__init__()
        self._half_map = CELLS / 2 * layout.resolution / layout.height_range
        self._scale = layout.height_range / LARGEST_RISE
        self.points = nn.Sequential(
            nn.Conv2d(Place.CHANNELS, HIDDEN, 1), nn.ReLU(inplace=True), nn.Conv2d(HIDDEN, 2 * POINTS, 1)
        )
        last = self.points[-1]
        assert isinstance(last, nn.Conv2d) and last.bias is not None
        nn.init.zeros_(last.weight)
        nn.init.zeros_(last.bias)
        left = 1 - (torch.arange(POINTS) + 1) / (POINTS + 1)  # Of the way from the hip to the foot.
        self.register_buffer("left", left, persistent=False)

    def forward(self, place: Tensor, depth: Tensor, known: Tensor) -> Tensor:
        """(n, 5, 40, 40) of Place, (n, 1, 40, 40) depth and 1 where it is known -> (n, POINTS, 40, 40)."""
        with float32():
            height = (1 - depth) * known
            # grid_sample wants (column, row), each -1 to 1 from border to border of the map.
            foot = place[:, [4, 3]].permute(0, 2, 3, 1).unsqueeze(3) / self._half_map  # (n, 40, 40, 1, 2)
            moved = self.points(place).permute(0, 2, 3, 1).reshape(-1, CELLS, CELLS, POINTS, 2) * STEP
            at = foot * self.get_buffer("left")[:, None] + moved  # (n, 40, 40, POINTS, 2)
            highest = functional.max_pool2d(height, 3, stride=1, padding=1)
            ground = functional.grid_sample(highest, at.flatten(2, 3), align_corners=False)  # (n, 1, 40, 40 POINTS)
            ground = ground.reshape(-1, CELLS, CELLS, POINTS).permute(0, 3, 1, 2)
            rise: Tensor = (ground - height) * self._scale
            return rise
