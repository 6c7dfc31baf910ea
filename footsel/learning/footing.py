"""How well a foot would stand on a cell: what the terrain cost sees, as fixed layers.

The cost turns on millimetres, but a height in the input is a share of 0.85 m, where bfloat16 resolves 2 to 3 mm. A
difference to a neighbour, scaled so that what matters fills [0, 1], keeps its digits in any later arithmetic. These
layers therefore compute in the input's float32 even under autocast. They export to plain operators.
"""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.learning.constants import keep_constant
from footsel.learning.grid import on_grid
from footsel.learning.precision import own_precision
from footsel.oracle.terrain_cost import LARGEST_DROP, LARGEST_FEATURE, PLANE, STENCIL, TerrainCostModel

#: Less than the share of one neighbour of the outer ring: no neighbour is known.
NONE_KNOWN = 0.01


class Footing(nn.Module):
    """The terrain cost and what it follows from, as footsel.oracle.terrain_cost for maps of cells of its spacing.

    The planes: K1 and K2 of the neighbours that are known; both times the share of these; the share; the cost c_m,
    all those of the oracle where the cell is known. Nothing here is learnt.
    """

    CHANNELS = 6

    def __init__(self, layout: LegLayout) -> None:
        super().__init__()
        self.foot_surface = FootSurface(layout)
        weights = STENCIL[:, 2]
        self.neighbours = Neighbours(layout.height_range, weights)
        keep_constant(self, "slopes", np.append(weights, 0.0)[None] * LARGEST_DROP / PLANE)
        # What unknown neighbours add to both sums, if all of them are unknown.
        self._unknown = float(weights.sum()) * LARGEST_DROP / PLANE
        exponent, constant, peaks = _mixture(TerrainCostModel.load())
        keep_constant(self, "exponent", exponent)
        keep_constant(self, "constant", constant[:, None])
        keep_constant(self, "peaks", peaks)

    def forward(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, 1, 40, 40) depth in [0, 1] and 1 where it is known -> (n, 6, 1600)."""
        with own_precision():
            neighbours = self.neighbours(self.foot_surface(depth, known), known).flatten(2)
            weights, share = self.get_buffer("slopes"), neighbours[:, -1:]
            sums = torch.cat([weights @ neighbours, weights @ neighbours.abs()], dim=1)
            counted = (sums - (1 - share) * self._unknown) * known.flatten(2)
            slopes = counted / share.clamp(min=NONE_KNOWN)

            # Of two readings the worse: missing neighbours make the rest less sure, or are as deep as can be.
            readings = torch.cat([slopes, counted + (1 - share) * LARGEST_FEATURE], dim=1)
            products = readings[:, ::2] * readings[:, 1::2]
            powers = torch.cat([readings, readings * readings, products], dim=1)
            exponents = self.get_buffer("exponent") @ powers + self.get_buffer("constant")
            quality = (self.get_buffer("peaks") @ exponents.exp()).clamp(max=1)
            cost = 1 - torch.minimum(quality[:, :1] * share, quality[:, 1:])
            return torch.cat([slopes, counted, share, cost], dim=1)


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
        sinking = torch.where(aside < layout.foot_radius**2, on_grid(sinking / layout.height_range), 1.0)
        keep_constant(self, "sinking", sinking.reshape(9))
        keep_constant(self, "weight", np.eye(9).reshape(9, 1, 3, 3))

    def forward(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, 1, h, w) depth in [0, 1] and 1 where it is known -> the same shape."""
        with own_precision():
            height = (1 - depth) * known
            touching = functional.conv2d(height, self.get_buffer("weight"), -self.get_buffer("sinking"), padding=1)
            return 1 - touching.amax(dim=1, keepdim=True)


class Neighbours(nn.Module):
    """A cell's 24 nearest, the stencil of the terrain cost: how much lower they lie, and how many of them are known.

    Drops in [-1, 1], 1 where a neighbour lies LARGEST_DROP lower or more, -1 where it lies as much higher. An unknown
    neighbour, also one beyond the map, counts as 1, which is easily taken off a sum again. Of unknown cells they mean
    nothing. Last the share of the neighbours that is known, by weight. One convolution, as each costs an engine more
    than a channel more.

    height_range: depth that the input shows as 1, in [m]. weights: (24,) of the neighbours, row by row.
    """

    CHANNELS = 25

    def __init__(self, height_range: float, weights: NDArray[np.float64]) -> None:
        super().__init__()
        scale = height_range / LARGEST_DROP
        neighbours = [(i, j) for i in range(5) for j in range(5) if (i, j) != (2, 2)]
        weight = torch.zeros(self.CHANNELS, 2, 5, 5)
        for channel, (i, j) in enumerate(neighbours):
            # Depth grows downwards.
            weight[channel, 0, i, j], weight[channel, 0, 2, 2] = scale, -scale
            # The bias, which a known neighbour cancels, is more than any depth of the cell takes off.
            weight[channel, 1, i, j] = -2 * scale
            weight[-1, 1, i, j] = weights[channel] / weights.sum()
        keep_constant(self, "weight", weight)
        keep_constant(self, "bias", np.append(np.full(len(neighbours), 2 * scale), 0.0))

    def forward(self, depth: Tensor, known: Tensor) -> Tensor:
        """(n, 1, h, w) depth in [0, 1] and 1 where it is known -> (n, 25, h, w)."""
        with own_precision():
            planes = torch.cat([depth * known, known], dim=1)
            weight, bias = self.get_buffer("weight"), self.get_buffer("bias")
            return functional.conv2d(planes, weight, bias, padding=2).clamp(-1, 1)


def _mixture(model: TerrainCostModel) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The quality of two readings as two sums over channels, with an exponential between.

    The first, weight (2 m, 10) and bias (2 m,), turns K1, K2, K1', K2', their squares, K1 K2 and K1' K2' into the
    exponents of the m Gaussians; the second (2, 2 m) adds the Gaussians.
    """
    count = len(model.gaussians)
    weight, bias, peaks = np.zeros((2, count, 10)), np.zeros((2, count)), np.zeros((2, 2, count))
    for number, g in enumerate(model.gaussians):
        # -(a^2 - 2 r a b + b^2) / 2 (1 - r^2), where a = (K1 - k1) / sigma_k1, and b as well.
        precision = np.linalg.inv(
            [
                [g.sigma_k1**2, g.correlation * g.sigma_k1 * g.sigma_k2],
                [g.correlation * g.sigma_k1 * g.sigma_k2, g.sigma_k2**2],
            ]
        )
        centre = np.array([g.k1, g.k2])
        for reading in range(2):
            weight[reading, number, 2 * reading : 2 * reading + 2] = precision @ centre
            weight[reading, number, 4 + 2 * reading : 6 + 2 * reading] = -np.diag(precision) / 2
            weight[reading, number, 8 + reading] = -precision[0, 1]
            bias[reading, number] = -centre @ precision @ centre / 2
            peaks[reading, reading, number] = g.weight
    return weight.reshape(-1, 10), bias.ravel(), peaks.reshape(2, -1)
