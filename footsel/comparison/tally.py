"""What is counted while selectors are compared: picks, cells and reasons of one leg on one map, and their sums."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import REASON_NAMES, Reason
from footsel.footholds.metrics import CellMetrics, PickMetrics
from footsel.oracle import Label
from footsel.runtime import CellEvaluation

NO_CELL = (-1, -1)


class Tally:
    """Counts over local maps.

    selectors: names of those that pick. judges_cells: whether a network's cells are counted too.
    """

    def __init__(self, selectors: Sequence[str], judges_cells: bool) -> None:
        self._picks = {name: PickMetrics() for name in selectors}
        self._reasons = np.zeros(len(REASON_NAMES), dtype=np.int64)
        self._asked = self._answerable = 0
        self._cells = CellMetrics() if judges_cells else None

    def update(
        self,
        label: Label,
        final_cost: NDArray[np.float64],
        cells: Mapping[str, tuple[int, int] | None],
        judged: CellEvaluation | None,
    ) -> None:
        """Add one local map.

        label: the oracle's. final_cost: (n, n) by the oracle's cost, inf where infeasible.
        cells: selector -> the cell it chose. judged: the network's cells.
        """
        self._asked += 1
        self._answerable += int(label.feasible.any())
        self._reasons += np.bincount(label.reason.ravel(), minlength=len(REASON_NAMES))
        for name, cell in cells.items():
            self._picks[name].update([NO_CELL if cell is None else cell], final_cost[None], label.reason[None])
        if self._cells is not None and judged is not None:
            self._cells.update(judged.class_, judged.cost, judged.feasible, label.cost, label.reason)

    def merge(self, other: "Tally") -> None:
        """Add all that another tally of the same selectors has counted."""
        for name, picks in self._picks.items():
            picks.merge(other._picks[name])
        self._reasons += other._reasons
        self._asked += other._asked
        self._answerable += other._answerable
        if self._cells is not None and other._cells is not None:
            self._cells.merge(other._cells)

    def result(self) -> dict[str, Any]:
        """selectors, cells: as in the metrics. asked: local maps; answerable: those with a foothold.
        reason_shares: of all cells, the oracle's view. infeasible_pick_reasons: selector -> reason -> how many of its
        picks the oracle rejects for it.
        """
        total = max(int(self._reasons.sum()), 1)
        selectors = {name: picks.result() for name, picks in self._picks.items()}
        return {
            "selectors": selectors,
            "cells": {} if self._cells is None else {"cnn": self._cells.result()},
            "asked": self._asked,
            "answerable": self._answerable,
            "reason_shares": {reason.name: int(self._reasons[reason]) / total for reason in Reason},
            "infeasible_pick_reasons": {name: figures["infeasible_by_reason"] for name, figures in selectors.items()},
        }


def total(tallies: Iterable[Tally], selectors: Sequence[str], judges_cells: bool) -> Tally:
    """The sum of tallies."""
    summed = Tally(selectors, judges_cells)
    for tally in tallies:
        summed.merge(tally)
    return summed
