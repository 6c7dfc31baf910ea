"""Looking up heights of the ground between cells, for the fixed layers."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from footsel.learning.constants import keep_constant
from footsel.terrain import CELLS

#: Rows and columns are counted from this one, in the middle of the map, where float32 resolves them best. A look-up
#: goes from the first to just short of the last, which so is the second of two. [cells]
ORIGIN = CELLS // 2
FIRST, LAST = float(-ORIGIN), float(np.nextafter(np.float32(CELLS - 1 - ORIGIN), np.float32(0)))
#: Row and column of the middle between the four cells in the middle: of the point below the hip.
MIDDLE = (CELLS - 1) / 2 - ORIGIN


class LookUp(nn.Module):
    """Heights at any places of one or several maps.

    maps: (places,) which of the maps each place is looked up in.
    """

    def __init__(self, maps: NDArray[np.intp]) -> None:
        super().__init__()
        keep_constant(self, "index", np.array([[float(CELLS), 1.0]]))
        keep_constant(self, "first_index", (maps * CELLS**2 + ORIGIN * (CELLS + 1)).astype(float)[None])

    def forward(self, heights: Tensor, at: Tensor) -> Tensor:
        """(n, maps, 40, 40) and (n, 2, places) rows and columns from ORIGIN -> (n, 1, places), in the input's unit.

        Of two triangles between four cells, as the oracle's terrain; and so continuous: rounding decides nothing, and
        engines that round differently agree.
        """
        at = at.clamp(FIRST, LAST)
        # The cell whose corner is the least of four; maps lie one after the other.
        corner = at.floor()
        along, across = (at - corner).chunk(2, dim=1)
        index = (self.get_buffer("index") @ corner + self.get_buffer("first_index")).long()
        # Values there, and by how much they change over a row, over a column and over both.
        values = heights.reshape(-1, 1, heights.shape[1] * CELLS**2)
        down, right = values[..., CELLS:] - values[..., :-CELLS], values[..., 1:] - values[..., :-1]
        twist = down[..., 1:] - down[..., :-1]
        value, down, right, twist = (torch.gather(part, 2, index) for part in (values, down, right, twist))
        return value + along * down + across * right + torch.minimum(along, across) * twist
