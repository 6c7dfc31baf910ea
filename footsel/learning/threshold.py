"""Where to draw the line on p(infeasible): chosen on held-out maps by what it does to the footholds picked."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from footsel.dataset.samples import Samples
from footsel.footholds import LegLayout, Reason
from footsel.footholds.metrics import PickMetrics
from footsel.learning.picks import final_cost_maps, nominal_distances, pick_cells
from footsel.learning.predictions import Predictions

#: From "more likely than not" down to "hardly thinkable", a fifth to a half lower each time.
THRESHOLDS = (
    0.5,
    0.4,
    0.3,
    0.25,
    0.2,
    0.15,
    0.1,
    0.07,
    0.05,
    0.03,
    0.02,
    0.015,
    0.01,
    0.007,
    0.005,
    0.003,
    0.002,
    0.001,
)

#: What a robot is allowed: one pick in 200 that the oracle rejects, one map in 100 left without an answer for nothing.
MOST_INFEASIBLE_PICKS = 0.005
MOST_MISSED = 0.01


def threshold_curve(predictions: Predictions, samples: Samples, layout: LegLayout, leg: str) -> list[dict[str, Any]]:
    """One entry per threshold, the highest first: how cells and picks fare if cells below it count as feasible.

    missed_rate: share of the maps with a foothold by the oracle on which none is found. The other rates are those of
    footsel.footholds.metrics.
    """
    distances = nominal_distances(layout, leg, samples.roll, samples.pitch)
    feasible = samples.reason == Reason.FEASIBLE
    rejected = predictions.known & ~feasible
    oracle_final = final_cost_maps(samples.cost, feasible, distances)
    maps_with_foothold = int(feasible.any(axis=(1, 2)).sum())
    curve = []
    for threshold in THRESHOLDS:
        called = predictions.feasible(threshold)
        cells = pick_cells(final_cost_maps(predictions.cost, called, distances), distances)
        picks = PickMetrics()
        picks.update(cells, oracle_final, predictions.known)
        figures = picks.result()
        curve.append(
            {
                "feasible_below": threshold,
                **figures,
                "missed_rate": figures["missed"] / max(maps_with_foothold, 1),
                "false_safe_rate": float(np.sum(called & rejected) / max(np.sum(rejected), 1)),
                "false_unsafe_rate": float(np.sum(feasible & ~called) / max(np.sum(feasible), 1)),
            }
        )
    return curve


def choose_feasible_below(curve: Sequence[Mapping[str, Any]]) -> float:
    """The highest threshold that keeps both limits, MOST_INFEASIBLE_PICKS and MOST_MISSED.

    If none does, the one that exceeds them least in all, each rate counted in units of its limit: safety bought by
    never answering is no safety, and neither is the reverse.
    """

    def excess(point: Mapping[str, Any]) -> float:
        infeasible, missed = float(point["infeasible_rate"] or 0.0), float(point["missed_rate"])
        return infeasible / MOST_INFEASIBLE_PICKS + missed / MOST_MISSED

    safe = [
        point
        for point in curve
        if (point["infeasible_rate"] or 0.0) <= MOST_INFEASIBLE_PICKS and point["missed_rate"] <= MOST_MISSED
    ]
    if safe:
        return float(max(safe, key=lambda point: float(point["feasible_below"]))["feasible_below"])
    return float(min(curve, key=excess)["feasible_below"])
