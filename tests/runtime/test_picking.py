"""The cheapest cell: equal costs go to the cell nearer to the nominal foothold, however many cells are asked for."""

import numpy as np

from footsel.runtime.picking import FinalCosts


def final_costs(total, distances):
    return FinalCosts(np.asarray(total, dtype=np.float32), np.asarray(distances, dtype=np.float32))


def test_equal_costs_go_to_the_nearer_cell():
    rng = np.random.default_rng(0)
    total = rng.integers(1, 4, (50, 1600)).astype(np.float32)
    total[rng.random(total.shape) < 0.3] = np.inf
    total[7] = np.inf
    costs = final_costs(total, rng.random(total.shape))
    best = costs.best
    for leg in range(50):
        if leg == 7:
            assert costs.ranked(leg, 1) == costs.ranked(leg, 5) == []
            continue
        cheapest = np.flatnonzero(total[leg] == total[leg].min())
        assert best[leg] == cheapest[np.argmin(costs.distances[leg, cheapest])]
        assert costs.ranked(leg, 1) == costs.ranked(leg, 5)[:1] == [best[leg]]


def test_without_ties_it_is_the_cheapest():
    rng = np.random.default_rng(1)
    costs = final_costs(rng.random((4, 1600)), rng.random((4, 1600)))
    np.testing.assert_array_equal(costs.best, costs.total.argmin(axis=1))
