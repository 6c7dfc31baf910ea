"""What the classic scorers share: from a judgement of the ground to costs, refusals and a reason for "none"."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import CellScores
from footsel.footholds.cost import INFEASIBLE_COST, MAX_FEASIBLE_COST
from footsel.footholds.request import LegRequest
from footsel.selectors.base import Selector


@dataclass(frozen=True, eq=False)
class Judgement:
    """What a scorer thinks of every cell.

    badness: (n, n) 0 for flat ground, 1 for the worst; NaN where too little is known around a cell to judge it.
    rejected: what a cell is refused for -> (n, n) where.
    """

    badness: NDArray[np.float64]
    rejected: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)

    @property
    def acceptable(self) -> NDArray[np.bool_]:
        """(n, n) cells that were judged and not refused."""
        refused = np.isnan(self.badness)
        for cells in self.rejected.values():
            refused = refused | cells
        return ~refused


class TerrainScorer(Selector):
    """A selector that judges the shape of the ground alone: `255 badness + k d_n` over the known cells it accepts."""

    @abstractmethod
    def judge(self, heights: NDArray[np.float64], resolution: float) -> Judgement:
        """Judge every cell. heights: (n, n) in [m], NaN = unknown. resolution: side of a cell, in [m]."""

    def score(self, request: LegRequest) -> CellScores:
        """Costs in [0, 254]; that of a cell which is unknown or refused means nothing."""
        local_map = request.local_map
        judgement = self.judge(local_map.heights.astype(np.float64), local_map.resolution)
        cost = (np.nan_to_num(judgement.badness, nan=1.0) * INFEASIBLE_COST).clip(0.0, MAX_FEASIBLE_COST)
        acceptable = judgement.acceptable & local_map.known
        # Only an answer of "none" needs its reason.
        why_none = "" if acceptable.any() else _why_none(judgement, local_map.known)
        return CellScores(cost, acceptable, why_none)


def _why_none(judgement: Judgement, known: NDArray[np.bool_]) -> str:
    """How many known cells were refused for what; a cell refused twice counts twice."""
    counts = {"with too little known around": int((np.isnan(judgement.badness) & known).sum())}
    counts |= {what: int((cells & known).sum()) for what, cells in judgement.rejected.items()}
    refusals = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    return f"no known cell is acceptable: {refusals}"
