"""What the ground looks like from each cell: fixed layers of differences in height, exact to float32 rounding.

The terrain cost turns on millimetres, but a height in the input is a share of 0.85 m, where bfloat16 resolves 2 to
3 mm. A difference to a neighbour, scaled so that what matters fills [0, 1], keeps its digits in any later arithmetic.
These layers therefore compute in float32 even under autocast. As convolutions with constant weights and a clip, they
export to plain operators.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.learning.float32 import float32

#: A drop counts up to this, as in the terrain cost. [m]
LARGEST_DROP = 0.05
#: A rise of the ground is seen up to this: about what the leg clears at the distance of the farthest ring. [m]
LARGEST_RISE = 0.3
#: Rises are taken from the highest cell of blocks this wide, at this many rings of blocks around the cell. [cells]
RISE_BLOCKS = ((3, 1), (5, 1), (9, 1))


class FootSurface(nn.Module):
    """Depth of the lowest point of a foot that touches the ground from above each cell: what the terrain cost sees.

    As footsel.oracle.terrain_cost.foot_surface for maps of the layout's cell size: the foot, a ball, rests on its cell
    or on one of the eight around, where it reaches less far down. Unknown cells hold no foot.
    """

    def __init__(self, layout: LegLayout) -> None:
        super().__init__()
        aside = torch.tensor([[a * a + b * b for b in (-1, 0, 1)] for a in (-1, 0, 1)]).double() * layout.resolution**2
        sinking = layout.foot_radius - (layout.foot_radius**2 - aside).clamp(min=0).sqrt()
        # Beside the foot there is nothing to rest on: deeper than the image goes.
        sinking = torch.where(aside < layout.foot_radius**2, sinking / layout.height_range, 1.0)
        self.register_buffer("sinking", sinking.float().reshape(9), persistent=False)
        self.register_buffer("weight", torch.eye(9).reshape(9, 1, 3, 3), persistent=False)

    def forward(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, 1, h, w) depth in [0, 1] and 1 where it is known -> the same shape."""
        with float32():
            height = (1 - depth) * known
            touching = functional.conv2d(height, self.get_buffer("weight"), -self.get_buffer("sinking"), padding=1)
            return 1 - touching.amax(dim=1, keepdim=True)


class Drops(nn.Module):
    """Differences in height between a cell and its 24 nearest, the stencil of the terrain cost.

    Outputs in [0, 1], 1 at LARGEST_DROP: 24 by which a neighbour lies lower, 24 by which it lies higher. The signed
    drop is the first minus the second, the absolute one their sum. An unknown neighbour, also one beyond the map, is
    neither lower nor higher; an unknown cell has no neighbours.

    height_range: depth that the input shows as 1, in [m].
    """

    CHANNELS = 48

    def __init__(self, height_range: float) -> None:
        super().__init__()
        scale = height_range / LARGEST_DROP
        neighbours = [(i, j) for i in range(5) for j in range(5) if (i, j) != (2, 2)]
        weight = torch.zeros(self.CHANNELS, 2, 5, 5)
        for index, (i, j) in enumerate(neighbours):
            for channel, sign in ((index, scale), (24 + index, -scale)):
                # Depth grows downwards.
                weight[channel, 0, i, j], weight[channel, 0, 2, 2] = sign, -sign
                # An unknown cell counts as depth 0; then the bias, which two known cells cancel, keeps the sum below 0.
                weight[channel, 1, i, j] = weight[channel, 1, 2, 2] = scale
        self.register_buffer("weight", weight, persistent=False)
        self.register_buffer("bias", torch.full((self.CHANNELS,), -2 * scale), persistent=False)

    def forward(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, 1, h, w) depth in [0, 1] and 1 where it is known -> (n, 48, h, w)."""
        with float32():
            planes = torch.cat([depth * known, known], dim=1)
            weight, bias = self.get_buffer("weight"), self.get_buffer("bias")
            return functional.conv2d(planes, weight, bias, padding=2).clamp(0, 1)


class KnownShares(nn.Module):
    """Which share of each ring of the drops' stencil is known: what is unknown raises the terrain cost."""

    CHANNELS = 2

    def __init__(self) -> None:
        super().__init__()
        weight = torch.zeros(self.CHANNELS, 1, 5, 5)
        weight[1] = 1 / 16
        weight[0, 0, 1:4, 1:4], weight[1, 0, 1:4, 1:4] = 1 / 8, 0
        weight[0, 0, 2, 2] = 0
        self.register_buffer("weight", weight, persistent=False)

    def forward(self, known: Tensor) -> Tensor:
        """(n, 1, h, w) 1 where a height is known -> (n, 2, h, w) in [0, 1]."""
        return functional.conv2d(known, self.get_buffer("weight"), padding=2)


class Rises(nn.Module):
    """How far blocks of cells farther off stand out above a cell: what a leg may run into.

    Outputs in [0, 1], 1 at LARGEST_RISE. Unknown cells and those beyond the map are never higher.

    height_range: depth that the input shows as 1, in [m].
    """

    CHANNELS = sum((2 * rings + 1) ** 2 - 1 for _, rings in RISE_BLOCKS)

    def __init__(self, height_range: float) -> None:
        super().__init__()
        scale = height_range / LARGEST_RISE
        for number, (_, rings) in enumerate(RISE_BLOCKS):
            side = 2 * rings + 1
            blocks = [(i, j) for i in range(side) for j in range(side) if (i, j) != (rings, rings)]
            weight = torch.zeros(len(blocks), 2, side, side)
            for channel, (i, j) in enumerate(blocks):
                weight[channel, 0, i, j], weight[channel, 1, rings, rings] = scale, -scale
            self.register_buffer(f"weight_{number}", weight, persistent=False)

    def forward(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, 1, h, w) depth in [0, 1] and 1 where it is known -> (n, CHANNELS, h, w)."""
        with float32():
            height = (1 - depth) * known
            rises = []
            for number, (block, rings) in enumerate(RISE_BLOCKS):
                highest = functional.max_pool2d(height, block, stride=1, padding=block // 2)
                planes, weight = torch.cat([highest, height], dim=1), self.get_buffer(f"weight_{number}")
                rises.append(functional.conv2d(planes, weight, padding=rings * block, dilation=block).clamp(0, 1))
            return torch.cat(rises, dim=1)
