"""Whether probabilities mean what they say: of the cells given 20 %, do 20 % turn out so?"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Edges of the bins between 0 and 1, even steps of the log-odds (0.5 % ... 99.5 %) and closer than even bins at both
#: ends, where a threshold lies and where most cells are.
EDGES: NDArray[np.float64] = np.round(1 / (1 + np.exp(-np.linspace(-7, 7, 21))), 4)


class Reliability:
    """Accumulates probabilities and what became of them.

    Guo et al., "On Calibration of Modern Neural Networks" (ICML 2017), for the diagram and the expected calibration
    error. Their remedy, one temperature for all logits, betters the error of the most probable class and worsens that
    of p(infeasible), on which safety rests (docs/judging.md), so there is none.
    """

    def __init__(self) -> None:
        bins = len(EDGES) + 1
        self._count = np.zeros(bins, dtype=np.int64)
        self._happened = np.zeros(bins, dtype=np.int64)
        self._probability = np.zeros(bins)

    def update(self, probability: ArrayLike, happened: ArrayLike) -> None:
        """Add events of any one shape, their probabilities and whether they happened."""
        probability = np.asarray(probability, dtype=np.float64).ravel()
        index = np.digitize(probability, EDGES)
        bins = len(self._count)
        self._count += np.bincount(index, minlength=bins)
        self._happened += np.bincount(index[np.asarray(happened, dtype=bool).ravel()], minlength=bins)
        self._probability += np.bincount(index, weights=probability, minlength=bins)

    def result(self) -> dict[str, Any]:
        """ece: mean distance of probability and frequency over the bins, weighted by their events; None without any.
        bins: of those with events, from, to, count, mean probability and frequency.
        """
        used = np.flatnonzero(self._count)
        count = self._count[used]
        probability, frequency = self._probability[used] / count, self._happened[used] / count
        limits = np.concatenate([[0.0], EDGES, [1.0]])
        error = float(np.sum(count * np.abs(probability - frequency)) / count.sum()) if used.size else None
        return {
            "ece": error,
            "bins": [
                {"from": low, "to": high, "count": n, "probability": p, "frequency": f}
                for low, high, n, p, f in zip(
                    limits[used].tolist(),
                    limits[used + 1].tolist(),
                    count.tolist(),
                    probability.tolist(),
                    frequency.tolist(),
                    strict=True,
                )
            ],
        }
