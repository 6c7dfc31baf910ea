"""How sure a few walks make us: intervals of rates and of paired differences."""

from collections.abc import Sequence

import numpy as np
from scipy import stats

#: Resamples of a bootstrap interval.
RESAMPLES = 4000


def wilson_interval(successes: int, n: int) -> tuple[float, float]:
    """95 % interval of a success rate (Wilson 1927); it is never empty and stays within 0 and 1."""
    if n == 0:
        return 0.0, 1.0
    interval = stats.binomtest(successes, n).proportion_ci(0.95, method="wilson")
    return float(interval.low), float(interval.high)


def bootstrap_interval(differences: Sequence[float]) -> tuple[float, float]:
    """95 % interval of the mean of paired differences, by resampling pairs (Efron's percentiles)."""
    values = np.asarray(differences, dtype=np.float64)
    if np.ptp(values) == 0:
        return float(values[0]), float(values[0])
    found = stats.bootstrap(
        (values,), np.mean, n_resamples=RESAMPLES, method="percentile", random_state=np.random.default_rng(0)
    )
    return float(found.confidence_interval.low), float(found.confidence_interval.high)


def sign_test(differences: Sequence[float]) -> float:
    """Two-sided p-value that pairs differ this one-sidedly by chance; equal pairs say nothing."""
    more, less = sum(d > 0 for d in differences), sum(d < 0 for d in differences)
    return float(stats.binomtest(more, more + less).pvalue) if more + less else 1.0
