"""Where to draw the line on p(infeasible): chosen on held-out maps by what it does to the footholds picked."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.dataset.samples import Samples
from footsel.footholds import LegLayout, Reason
from footsel.footholds.metrics import PickMetrics
from footsel.learning.picks import final_cost_maps, nominal_distances, picks_below
from footsel.learning.predictions import Predictions

#: From "most improbable to be feasible" down to "hardly thinkable that it is not": odds of 9.5 to 1 down to 1 to 850,
#: each about four fifths of the one before.
THRESHOLDS: tuple[float, ...] = tuple(np.round(1 / (1 + np.exp(-np.arange(9, -28, -1) / 4)), 5).tolist())

#: What a robot is allowed: one pick in 143 that the oracle rejects, one map in 100 left without an answer for
#: nothing. Never answering is no safety, and neither is an answer at any price.
MOST_INFEASIBLE_PICKS = 0.007
MOST_MISSED = 0.01
#: Terrain of a kind that was never trained on is missed up to twice as often (docs/learning.md), so on terrain that was
#: a threshold goes for half of that.
MISSED_AIM = MOST_MISSED / 2

#: Roll and pitch of the base that a threshold is chosen for, as far as `footsel compare` tilts it. [rad]
USUAL_TILT = float(np.deg2rad(10.0))


class ThresholdCurve:
    """Accumulates how cells and picks fare at every threshold, if cells below it count as feasible."""

    def __init__(self, layout: LegLayout, leg: str) -> None:
        self._layout = layout
        self._leg = leg
        self._picks = [PickMetrics() for _ in THRESHOLDS]
        #: Known cells by whether the oracle calls them feasible and by how many thresholds lie above their probability.
        self._cells = np.zeros((2, len(THRESHOLDS) + 1), dtype=np.int64)

    def update(self, predictions: Predictions, samples: Samples) -> None:
        """Add the predictions for `samples`."""
        distances = nominal_distances(self._layout, self._leg, samples.roll, samples.pitch)
        feasible = samples.reason == Reason.FEASIBLE
        oracle_final = final_cost_maps(samples.cost, feasible, distances)
        final = final_cost_maps(predictions.cost, predictions.known, distances)
        chosen = picks_below(final, distances, predictions.infeasible, THRESHOLDS)
        for picks, cells in zip(self._picks, chosen, strict=True):
            picks.update(cells, oracle_final, samples.reason)
        judged = samples.reason != Reason.UNKNOWN
        rising = np.array(THRESHOLDS[::-1], dtype=np.float32)
        above = len(rising) - np.searchsorted(rising, predictions.infeasible[judged], side="right")
        for row, cells in enumerate((~feasible[judged], feasible[judged])):
            self._cells[row] += np.bincount(above[cells], minlength=len(THRESHOLDS) + 1)

    def result(self) -> list[dict[str, Any]]:
        """One entry per threshold, the highest first: feasible_below and the figures of footsel.footholds.metrics."""
        # A cell with n thresholds above its probability is called feasible at the n highest.
        called = self._cells.sum(axis=1, keepdims=True) - np.cumsum(self._cells, axis=1)
        infeasible, feasible = self._cells.sum(axis=1).tolist()
        return [
            {
                "feasible_below": threshold,
                **picks.result(),
                "false_safe_rate": int(called[0, index]) / max(infeasible, 1),
                "false_unsafe_rate": (feasible - int(called[1, index])) / max(feasible, 1),
            }
            for index, (threshold, picks) in enumerate(zip(THRESHOLDS, self._picks, strict=True))
        ]


def threshold_curve(predictions: Predictions, samples: Samples, layout: LegLayout, leg: str) -> list[dict[str, Any]]:
    """The curve of maps that are all in memory."""
    curve = ThresholdCurve(layout, leg)
    curve.update(predictions, samples)
    return curve.result()


def usual(samples: Samples) -> NDArray[np.bool_]:
    """(n,) which maps are of a base no further tilted than USUAL_TILT; all, if none is.

    A dataset has more tilt than robots should have, to learn from. There both kinds of mistake are commoner, and which
    of the two is nearer to its limit is another matter.
    """
    level = np.maximum(np.abs(samples.roll), np.abs(samples.pitch)) <= USUAL_TILT
    return np.asarray(level if level.any() else np.ones(len(samples), dtype=bool))


def choose_feasible_below(curve: Sequence[Mapping[str, Any]]) -> float:
    """The threshold that keeps best to both limits: the two rates, each over its aim, squared and added, are least.

    Squares weigh the rate that is further off. The larger of the two alone would let the other grow for nothing, and
    on a few thousand picks it is a matter of chance which one is the larger.
    Among equals the one with fewer infeasible picks wins, then the higher one, which forbids the fewest cells.
    """

    def badness(point: Mapping[str, Any]) -> tuple[float, float, float]:
        infeasible, missed = _rate(point, "infeasible_rate"), _rate(point, "missed_rate")
        both = (infeasible / MOST_INFEASIBLE_PICKS) ** 2 + (missed / MISSED_AIM) ** 2
        return both, infeasible, -float(point["feasible_below"])

    return float(min(curve, key=badness)["feasible_below"])


def at_missed(curve: Sequence[Mapping[str, Any]], missed_rate: float) -> dict[str, float] | None:
    """infeasible_rate and regret_mean where `missed_rate` of the footholds are missed, linear between two thresholds.

    So networks are compared that answer equally often. None if no two thresholds lie around that rate, or if one of
    them picks nothing.
    """
    for above, below in itertools.pairwise(curve):
        low, high = _rate(above, "missed_rate"), _rate(below, "missed_rate")
        if low <= missed_rate <= high and low < high:
            share = (missed_rate - low) / (high - low)
            keys = ("infeasible_rate", "regret_mean")
            if any(point[key] is None for point in (above, below) for key in keys):
                return None
            return {key: float(above[key] + share * (below[key] - above[key])) for key in keys}
    return None


def _rate(point: Mapping[str, Any], key: str) -> float:
    """A rate of the curve; without anything to count it is 0."""
    return float(point[key] or 0.0)
