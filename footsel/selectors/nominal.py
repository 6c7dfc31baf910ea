"""The nominal foothold, whatever lies there: what a gait without perception does."""

import numpy as np

from footsel.footholds import CellScores
from footsel.footholds.request import LegRequest
from footsel.selectors.base import Selector


class NominalSelector(Selector):
    """The known cell nearest to N_i; none if N_i's own cell is unknown."""

    def score(self, request: LegRequest) -> CellScores:
        local_map = request.local_map
        distances = local_map.distances_to(request.nominal[:2])
        here = bool(local_map.known.ravel()[distances.argmin()])
        feasible = np.full(local_map.known.shape, here)
        return CellScores(np.zeros(feasible.shape), feasible, "the nominal foothold's cell is unknown")
