"""From what networks say of every cell to the cell that is picked: `footholds.choice` for many legs at once.

All is in the mirrored maps of LegFrames; only what is picked is turned into cells and positions of the world.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.choice import ranked_cells
from footsel.runtime.leg_frames import LegFrames
from footsel.runtime.sampling import OFFSETS
from footsel.terrain import CELLS


@dataclass(frozen=True, eq=False)
class Judgement:
    """What networks say of the maps of m legs.

    heights: (m, 40, 40) relative to L_i, NaN = unknown, in [m].
    infeasible: (m, 40, 40) probability of the class "infeasible". cost: (m, 40, 40) mean cost over all classes.
    feasible_below: (m,) a cell may be chosen if `infeasible` is below this.
    """

    heights: NDArray[np.float32]
    infeasible: NDArray[np.float32]
    cost: NDArray[np.float32]
    feasible_below: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class FinalCosts:
    """Final costs of the cells of m legs.

    total: (m, 1600) `Z_c + k d_n`, inf for cells that may not be chosen. distances: (m, 1600) d_n, in [m].
    """

    total: NDArray[np.float64]
    distances: NDArray[np.float64]

    def best(self) -> NDArray[np.intp]:
        """(m,) flat index of the cheapest cell of each leg."""
        return np.asarray(self.total.argmin(axis=1))

    def ranked(self, leg: int, most: int) -> list[int]:
        """Flat indices of one leg's cells that may be chosen, cheapest first, at most `most`."""
        total = self.total[leg]
        if most == 1:
            best = int(total.argmin())
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
    target = frames.in_map(frames.nominal[:, :2])
    along_x, along_y = (np.square(OFFSETS * resolution - target[:, axis, None]) for axis in (0, 1))
    distances = np.sqrt(along_x[:, :, None] + along_y[:, None, :])
    total = distances * distance_weight
    total += judgement.cost
    # Compared this way round, a NaN of a network forbids its cell.
    allowed = judgement.infeasible < judgement.feasible_below[:, None, None]
    allowed &= ~np.isnan(judgement.heights)
    if max_distance is not None:
        allowed &= distances <= max_distance
    np.copyto(total, np.inf, where=~allowed)
    return FinalCosts(total.reshape(len(target), -1), distances.reshape(len(target), -1))
