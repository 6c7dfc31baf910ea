"""How sure a few walks make us: intervals of rates and of paired differences."""

import math
from collections.abc import Sequence

import numpy as np

#: Of the standard normal distribution: 95 % lie within so many deviations.
Z95 = 1.959963984540054
#: Resamples of a bootstrap interval.
RESAMPLES = 4000


def wilson_interval(successes: int, n: int) -> tuple[float, float]:
    """95 % interval of a success rate (Wilson 1927); it is never empty and stays within 0 and 1."""
    if n == 0:
        return 0.0, 1.0
    rate, z2 = successes / n, Z95**2
    middle = (rate + z2 / (2 * n)) / (1 + z2 / n)
    half = Z95 / (1 + z2 / n) * math.sqrt(rate * (1 - rate) / n + z2 / (4 * n**2))
    # Rounding must not leave a border that is exact.
    low = 0.0 if successes == 0 else middle - half
    high = 1.0 if successes == n else middle + half
    return low, high


def bootstrap_interval(differences: Sequence[float]) -> tuple[float, float]:
    """95 % interval of the mean of paired differences, by resampling pairs (Efron's percentiles)."""
    values = np.asarray(differences, dtype=np.float64)
    draws = np.random.default_rng(0).integers(0, len(values), (RESAMPLES, len(values)))
    low, high = np.percentile(values[draws].mean(axis=1), [2.5, 97.5]).tolist()
    return low, high


def sign_test(differences: Sequence[float]) -> float:
    """Two-sided p-value that pairs differ this one-sidedly by chance; equal pairs say nothing."""
    more, less = sum(d > 0 for d in differences), sum(d < 0 for d in differences)
    n = more + less
    tail = sum(math.comb(n, k) for k in range(min(more, less) + 1)) / 2**n
    return float(min(1.0, 2 * tail))
