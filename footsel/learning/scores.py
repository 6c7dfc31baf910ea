"""The figures of a network on labelled maps: cells by the selector's rule and by the paper's, picks, probabilities."""

from typing import Any

import numpy as np

from footsel.dataset.samples import Samples
from footsel.footholds import LegLayout, Reason
from footsel.footholds.cost import INFEASIBLE_CLASS
from footsel.footholds.metrics import CellMetrics, PickMetrics
from footsel.learning.loss import LABEL_CLASS
from footsel.learning.picks import final_cost_maps, nominal_distances, pick_cells
from footsel.learning.predictions import Predictions
from footsel.learning.reliability import Reliability
from footsel.learning.threshold import ThresholdCurve


class Scores:
    """Accumulates maps of one leg.

    feasible_below: the selector's rule, a cell is feasible if p(infeasible) is below it.
    """

    def __init__(self, layout: LegLayout, leg: str, feasible_below: float) -> None:
        self._layout = layout
        self._leg = leg
        self._feasible_below = feasible_below
        self._maps = 0
        self._cells = CellMetrics()
        self._likeliest = CellMetrics()
        self._picks = PickMetrics()
        self._reliability = {name: Reliability() for name in ("infeasible", "likeliest", "picks")}

    def update(self, predictions: Predictions, samples: Samples) -> None:
        """Add the predictions for `samples`."""
        judged = predictions.decode(self._feasible_below)
        likeliest = predictions.likeliest
        self._maps += len(samples)
        self._cells.update(judged.class_, judged.cost, judged.feasible, samples.cost, samples.reason)
        self._likeliest.update(likeliest, predictions.cost, likeliest != INFEASIBLE_CLASS, samples.cost, samples.reason)
        distances = nominal_distances(self._layout, self._leg, samples.roll, samples.pitch)
        chosen = pick_cells(final_cost_maps(judged.cost, judged.feasible, distances), distances)
        feasible = np.equal(samples.reason, Reason.FEASIBLE)
        self._picks.update(chosen, final_cost_maps(samples.cost, feasible, distances), samples.reason)

        known = np.not_equal(samples.reason, Reason.UNKNOWN)
        right = likeliest == LABEL_CLASS[samples.cost]
        self._reliability["infeasible"].update(predictions.infeasible[known], ~feasible[known])
        self._reliability["likeliest"].update(predictions.likelihood[known], right[known])
        maps = np.flatnonzero(chosen[:, 0] >= 0)
        picks = (maps, *chosen[maps].T)
        self._reliability["picks"].update(judged.confidence[picks], feasible[picks])

    def result(self) -> dict[str, Any]:
        """maps: how many. cells: by the selector's rule. cells_likeliest: by the most probable of the fourteen
        classes, as the paper measures. picks: the footholds. Keys as in footsel.footholds.metrics.
        calibration (footsel.learning.reliability): of p(infeasible) and of the most probable class's probability, over
        known cells; of the picks' confidence, which is lower than it looks, for a choice goes where a network errs.
        """
        return {
            "maps": self._maps,
            "cells": self._cells.result(),
            "cells_likeliest": self._likeliest.result(),
            "picks": self._picks.result(),
            "calibration": {name: reliability.result() for name, reliability in self._reliability.items()},
        }


class Judgement:
    """Accumulates the scores of all maps, of each terrain family, and the curve of thresholds."""

    def __init__(self, layout: LegLayout, leg: str, feasible_below: float) -> None:
        self._rule = (layout, leg, feasible_below)
        self._all = Scores(*self._rule)
        self._families: dict[str, Scores] = {}
        self._curve = ThresholdCurve(layout, leg)

    def update(self, predictions: Predictions, samples: Samples) -> None:
        """Add the predictions for `samples`."""
        self._all.update(predictions, samples)
        self._curve.update(predictions, samples)
        for family in np.unique(samples.family).tolist():
            of_family = samples.family == family
            scores = self._families.setdefault(family, Scores(*self._rule))
            scores.update(predictions.take(of_family), samples.take(of_family))

    def result(self) -> dict[str, Any]:
        """{"all": figures, "families": {name: figures}, "thresholds": the curve}, figures as of Scores.result."""
        return {
            "all": self._all.result(),
            "families": {name: self._families[name].result() for name in sorted(self._families)},
            "thresholds": self._curve.result(),
        }
