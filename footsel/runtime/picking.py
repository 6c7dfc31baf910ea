"""From what networks say of every cell to the cell that is picked: `footholds.choice` for many legs at once.

All is in the mirrored maps of LegFrames; only what is picked is turned into cells and positions of the world.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.choice import ranked_cells
from footsel.runtime.judgement import Judgement
from footsel.runtime.leg_frames import LegFrames
from footsel.runtime.sampling import OFFSETS
from footsel.terrain import CELLS


@dataclass(frozen=True, eq=False)
class FinalCosts:
    """Final costs of the cells of m legs.

    total: (m, 1600) `Z_c + k d_n`, inf for cells that may not be chosen. distances: (m, 1600) d_n, in [m].
    """

    total: NDArray[np.float32]
    distances: NDArray[np.float32]

    @cached_property
    def best(self) -> NDArray[np.intp]:
        """(m,) flat index of the cheapest cell of each leg; equal costs go to the cell nearer to N_i."""
        best = self.total.argmin(axis=1)
        equal = self.total == self.total[np.arange(len(best)), best, None]
        # Rare but on level ground, where costs repeat from row to row.
        if np.count_nonzero(equal) > len(best):
            best = np.where(equal, self.distances, np.inf).argmin(axis=1)
        return np.asarray(best)

    def ranked(self, leg: int, most: int) -> list[int]:
        """Flat indices of one leg's cells that may be chosen, cheapest first, at most `most`."""
        total = self.total[leg]
        if most == 1:
            best = int(self.best[leg])
            return [best] if np.isfinite(total[best]) else []
        cells = ranked_cells(total.reshape(CELLS, CELLS), self.distances[leg], most)
        return [i * CELLS + j for i, j in cells.tolist()]


def weigh(
    judgement: Judgement, frames: LegFrames, resolution: float, distance_weight: float, max_distance: float | None
) -> FinalCosts:
    """Which cells may be chosen, and what each costs with its distance to N_i.

    resolution: side of a cell, in [m]. distance_weight: k, in [cost / m].
    max_distance: cells farther than this from N_i may not be chosen, in [m].
    """
    offsets = OFFSETS * resolution
    x, y = (
        np.square(offsets - target[:, None]).astype(np.float32) for target in frames.in_map(frames.nominal[:, :2])
    )  # (m, 40)
    distances = np.sqrt(x[:, :, None] + y[:, None, :])
    total = distances * np.float32(distance_weight)
    total += judgement.cost
    # Compared this way round, a NaN of a network forbids its cell.
    allowed = judgement.infeasible < judgement.feasible_below[:, None, None]
    allowed &= np.isfinite(judgement.heights)
    if max_distance is not None:
        # Not rounded to float32, which may lie beyond the limit.
        allowed &= distances.astype(np.float64) <= max_distance
    total = np.where(allowed, total, np.float32(np.inf))
    return FinalCosts(total.reshape(len(total), -1), distances.reshape(len(total), -1))
