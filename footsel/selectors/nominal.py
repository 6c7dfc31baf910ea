"""The nominal foothold, whatever lies there: what a gait without perception does."""

import numpy as np

from footsel.footholds import CellScores
from footsel.footholds.request import LegRequest
from footsel.selectors.base import Selector


class NominalSelector(Selector):
    """The cell nearest to N_i, and none beside it that a planner could choose instead; none if it is unknown."""

    def score(self, request: LegRequest) -> CellScores:
        local_map = request.local_map
        distances = local_map.distances_to(request.nominal[:2])
        feasible = np.zeros(local_map.known.shape, dtype=bool)
        feasible.flat[distances.argmin()] = True
        return CellScores(np.zeros(feasible.shape), feasible, "the nominal foothold's cell is unknown")
