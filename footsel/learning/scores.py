"""The figures of a network on labelled maps: cells by the selector's rule and by the paper's, and the picks."""

from typing import Any

import numpy as np

from footsel.dataset.samples import Samples
from footsel.footholds import LegLayout, Reason
from footsel.footholds.cost import INFEASIBLE_CLASS
from footsel.footholds.metrics import CellMetrics, PickMetrics
from footsel.learning.picks import final_cost_maps, nominal_distances, pick_cells
from footsel.learning.predictions import Predictions


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

    def update(self, predictions: Predictions, samples: Samples) -> None:
        """Add the predictions for `samples`."""
        judged = predictions.decode(self._feasible_below)
        likeliest = predictions.likeliest
        self._maps += len(samples)
        self._cells.update(judged.class_, judged.cost, judged.feasible, samples.cost, samples.reason)
        self._likeliest.update(likeliest, predictions.cost, likeliest != INFEASIBLE_CLASS, samples.cost, samples.reason)
        distances = nominal_distances(self._layout, self._leg, samples.roll, samples.pitch)
        chosen = pick_cells(final_cost_maps(judged.cost, judged.feasible, distances), distances)
        oracle_final = final_cost_maps(samples.cost, np.equal(samples.reason, Reason.FEASIBLE), distances)
        self._picks.update(chosen, oracle_final, predictions.known)

    def result(self) -> dict[str, Any]:
        """maps: how many. cells: by the selector's rule. cells_likeliest: by the most probable of the fourteen
        classes, as the paper measures. picks: the footholds. Keys as in footsel.footholds.metrics.
        """
        return {
            "maps": self._maps,
            "cells": self._cells.result(),
            "cells_likeliest": self._likeliest.result(),
            "picks": self._picks.result(),
        }
