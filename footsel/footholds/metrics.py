"""How far a judgement of cells, and the footholds picked by it, stand from the oracle's. One set of definitions for
`footsel evaluate` and `footsel compare`."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.footholds.cost import CLASSES, cost_to_class
from footsel.footholds.reasons import REASON_NAMES, Reason


class CellMetrics:
    """Accumulates a selector's judgement of cells against the oracle's labels; unknown cells do not count."""

    def __init__(self) -> None:
        #: Known cells by the oracle's class and the predicted one.
        self._confusion = np.zeros((CLASSES, CLASSES), dtype=np.int64)
        #: Known cells by the oracle's reason and whether they were called feasible.
        self._called_feasible = np.zeros((len(REASON_NAMES), 2), dtype=np.int64)
        #: Among cells feasible for both: right class, all, summed cost error.
        self._feasible_right = 0
        self._both_feasible = 0
        self._cost_error = 0.0

    def update(
        self,
        predicted_class: ArrayLike,
        predicted_cost: ArrayLike,
        predicted_feasible: ArrayLike,
        oracle_cost: ArrayLike,
        oracle_reason: ArrayLike,
    ) -> None:
        """Add cells; all arguments have one shape, say (n, 40, 40).

        predicted_class: 0..13. predicted_cost: in [0, 255], read only where both call the cell feasible.
        predicted_feasible: whether the selector may choose the cell, by its own rule.
        oracle_cost: in [0, 255], 255 = infeasible. oracle_reason: footsel.footholds.Reason.
        """
        reason = np.asarray(oracle_reason)
        known = reason != Reason.UNKNOWN
        reason = reason[known].astype(np.intp)
        classes = np.asarray(predicted_class)[known].astype(np.intp)
        feasible = np.asarray(predicted_feasible, dtype=bool)[known]
        cost = np.asarray(oracle_cost, dtype=np.float64)[known]
        oracle_classes = cost_to_class(cost).astype(np.intp)
        self._confusion += _count_pairs(oracle_classes, classes, self._confusion.shape)
        self._called_feasible += _count_pairs(reason, feasible.astype(np.intp), self._called_feasible.shape)
        oracle_feasible = reason == Reason.FEASIBLE
        self._feasible_right += int((oracle_classes == classes)[oracle_feasible].sum())
        both = feasible & oracle_feasible
        self._both_feasible += int(both.sum())
        self._cost_error += float(np.abs(np.asarray(predicted_cost, dtype=np.float64)[known] - cost)[both].sum())

    def merge(self, other: "CellMetrics") -> None:
        """Add all cells of another accumulation."""
        self._confusion += other._confusion
        self._called_feasible += other._called_feasible
        self._feasible_right += other._feasible_right
        self._both_feasible += other._both_feasible
        self._cost_error += other._cost_error

    def result(self) -> dict[str, Any]:
        """The figures; None where there was nothing to average over.

        accuracy: share of cells given the oracle's class. accuracy_feasible: the same among oracle-feasible cells.
        cost_mae: mean absolute error of the cost where both call the cell feasible.
        miou: intersection over union, mean over 14 classes, 0 for a class that is absent from both labels and
            predictions. miou_present: without those classes.
        false_safe_rate: share of oracle-infeasible cells called feasible. false_unsafe_rate: the reverse.
        recall_by_reason: reason -> share of its cells called as they are, feasible or not. cells_by_reason: how many.
        """
        total = int(self._confusion.sum())
        hits = np.diag(self._confusion)
        union = self._confusion.sum(axis=0) + self._confusion.sum(axis=1) - hits
        iou = hits / np.maximum(union, 1)
        by_reason = self._called_feasible.sum(axis=1)
        feasible = int(by_reason[Reason.FEASIBLE])
        infeasible = total - feasible
        false_unsafe = int(self._called_feasible[Reason.FEASIBLE, 0])
        false_safe = int(self._called_feasible[:, 1].sum()) - (feasible - false_unsafe)
        return {
            "accuracy": _share(int(hits.sum()), total),
            "accuracy_feasible": _share(self._feasible_right, feasible),
            "cost_mae": _share(self._cost_error, self._both_feasible),
            "miou": float(iou.mean()) if total else None,
            "miou_present": float(iou[union > 0].mean()) if total else None,
            "false_safe_rate": _share(false_safe, infeasible),
            "false_unsafe_rate": _share(false_unsafe, feasible),
            "recall_by_reason": {
                reason.name: _share(
                    int(self._called_feasible[reason, int(reason == Reason.FEASIBLE)]), int(by_reason[reason])
                )
                for reason in Reason
                if reason != Reason.UNKNOWN
            },
            "cells_by_reason": {reason.name: int(by_reason[reason]) for reason in Reason if reason != Reason.UNKNOWN},
        }


class PickMetrics:
    """Accumulates a selector's footholds against the oracle's final costs."""

    def __init__(self) -> None:
        self._asked = 0
        self._answerable = 0
        self._missed = 0
        #: Picks by the oracle's reason for their cell.
        self._picks = np.zeros(len(REASON_NAMES), dtype=np.int64)
        self._regrets: list[NDArray[np.float64]] = []

    def update(self, cells: ArrayLike, oracle_final_cost: ArrayLike, oracle_reason: ArrayLike) -> None:
        """Add one pick for each of n local maps.

        cells: (n, 2) the chosen cell (i, j), negative for "none".
        oracle_final_cost: (n, 40, 40) Z_c + k d_n by the oracle's cost, inf where the oracle finds no foothold.
        oracle_reason: (n, 40, 40) footsel.footholds.Reason.
        """
        cells = np.asarray(cells, dtype=np.intp).reshape(-1, 2)
        final = np.asarray(oracle_final_cost, dtype=np.float64)
        reason = np.asarray(oracle_reason)
        best = final.reshape(len(cells), -1).min(axis=1)
        picked = (cells >= 0).all(axis=1)
        maps = np.flatnonzero(picked)
        i, j = cells[picked].T
        pick_cost = final[maps, i, j]
        good = np.isfinite(pick_cost)
        self._asked += len(cells)
        self._answerable += int(np.isfinite(best).sum())
        self._missed += int((~picked & np.isfinite(best)).sum())
        self._picks += np.bincount(reason[maps, i, j], minlength=len(REASON_NAMES))
        self._regrets.append(pick_cost[good] - best[maps][good])

    def merge(self, other: "PickMetrics") -> None:
        """Add all picks of another accumulation."""
        self._asked += other._asked
        self._answerable += other._answerable
        self._missed += other._missed
        self._picks += other._picks
        self._regrets.extend(other._regrets)

    def result(self) -> dict[str, Any]:
        """The figures; None where there was nothing to average over.

        picks, none: maps with and without an answer. missed: none although the oracle has a feasible cell; missed_rate:
        their share of the maps where it has one. infeasible_picks: picks that the oracle rejects, infeasible_by_reason
        for what; unknown_picks, those of them on cells without a height. infeasible_rate: infeasible_picks / picks.
        regret_mean, regret_p95: the oracle's final cost of the pick minus that of its best cell, over the picks that
        the oracle accepts.
        """
        regrets = np.concatenate(self._regrets) if self._regrets else np.empty(0)
        picks = int(self._picks.sum())
        infeasible = picks - int(self._picks[Reason.FEASIBLE])
        return {
            "picks": picks,
            "none": self._asked - picks,
            "missed": self._missed,
            "missed_rate": _share(self._missed, self._answerable),
            "infeasible_picks": infeasible,
            "infeasible_by_reason": {r.name: int(self._picks[r]) for r in Reason if r != Reason.FEASIBLE},
            "unknown_picks": int(self._picks[Reason.UNKNOWN]),
            "infeasible_rate": _share(infeasible, picks),
            "regret_mean": float(regrets.mean()) if regrets.size else None,
            "regret_p95": float(np.percentile(regrets, 95)) if regrets.size else None,
        }


def _count_pairs(rows: NDArray[np.intp], columns: NDArray[np.intp], shape: tuple[int, ...]) -> NDArray[np.int64]:
    """How often each (row, column) occurs."""
    counts = np.bincount(rows * shape[1] + columns, minlength=shape[0] * shape[1])
    return counts.reshape(shape).astype(np.int64)


def _share(part: float, whole: int) -> float | None:
    return part / whole if whole else None
