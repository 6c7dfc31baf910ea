"""Intervals by their laws: they cover what they promise to cover."""

import numpy as np
import pytest

from footsel.comparison.walks.statistics import bootstrap_interval, sign_test, wilson_interval


@pytest.mark.parametrize("n", [5, 10, 20])
@pytest.mark.parametrize("rate", [0.1, 0.5, 0.9])
def test_wilson_borders_are_where_the_score_test_is_at_its_limit(n, rate):
    """A rate p is within the interval exactly if (successes - n p)^2 <= z^2 n p (1 - p)."""
    successes = round(rate * n)
    for p in wilson_interval(successes, n):
        if 0 < p < 1:
            assert (successes - n * p) ** 2 == pytest.approx(1.959963984540054**2 * n * p * (1 - p), rel=1e-9)


def test_wilson_at_the_borders():
    assert wilson_interval(0, 10)[0] == 0
    assert wilson_interval(10, 10)[1] == 1
    assert wilson_interval(10, 10)[0] == pytest.approx(1 - wilson_interval(0, 10)[1])
    assert wilson_interval(0, 0) == (0, 1)
    widths = [np.diff(wilson_interval(n // 2, n))[0] for n in (10, 100, 1000)]
    assert widths == sorted(widths, reverse=True)


def test_wilson_covers_about_as_often_as_it_says():
    drawn = np.random.default_rng(0).binomial(20, 0.8, 2000)
    intervals = np.array([wilson_interval(int(k), 20) for k in drawn])
    assert 0.92 < np.mean((intervals[:, 0] <= 0.8) & (intervals[:, 1] >= 0.8)) < 0.99


def test_bootstrap_covers_the_mean():
    rng = np.random.default_rng(1)
    covered = [
        low <= 2 <= high for low, high in (bootstrap_interval(rng.normal(2, 3, 25).tolist()) for _ in range(300))
    ]
    assert 0.88 < np.mean(covered) < 0.98


def test_bootstrap_of_equal_differences_is_a_point_and_always_the_same():
    assert bootstrap_interval([0.5] * 8) == (0.5, 0.5)
    differences = [0.1, -2.0, 3.0, 0.4]
    assert bootstrap_interval(differences) == bootstrap_interval(differences)
    low, high = bootstrap_interval(differences)
    assert bootstrap_interval([-d for d in differences]) == pytest.approx((-high, -low), abs=0.3)


def test_sign_test_against_its_enumeration():
    """Of all ways that the signs of 7 pairs may fall, as many are at least this one-sided."""
    signs = np.array(np.meshgrid(*[[-1, 1]] * 7)).reshape(7, -1)
    more = (signs > 0).sum(axis=0)
    for k in range(8):
        differences = [1.0] * k + [-1.0] * (7 - k)
        extreme = np.mean(np.abs(more - 3.5) >= abs(k - 3.5))
        assert sign_test(differences) == pytest.approx(extreme)
    assert sign_test([]) == sign_test([0.0, 0.0]) == 1.0
