"""The paper's cost, its classes, and the way back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footsel.footholds.cost import class_centres, cost_to_class, expected_cost, foothold_cost, softmax

unit = st.floats(0, 1)


@given(unit, unit)
def test_the_paper_s_equation(margin_cost, terrain_cost):
    assert foothold_cost(margin_cost, terrain_cost) == pytest.approx(
        min((margin_cost + 2 * terrain_cost) / 3 * 255, 254)
    )


@given(unit, unit, unit, unit)
def test_cost_never_falls_as_a_part_rises(a, b, c, d):
    low, high = sorted((a, b)), sorted((c, d))
    assert foothold_cost(low[0], high[0]) <= foothold_cost(low[1], high[1])


def test_the_terrain_weighs_twice():
    assert foothold_cost(0, 0.2) == pytest.approx(2 * foothold_cost(0.2, 0))


def test_classes_of_every_whole_cost():
    for cost in range(255):
        assert cost_to_class(cost) == cost * 13 // 255
    assert cost_to_class(255) == 13
    assert cost_to_class(254) == 12


@given(st.floats(0, 254.99))
def test_a_feasible_cost_is_in_its_class_s_bin(cost):
    class_ = int(cost_to_class(cost))
    width = 255 / 13
    assert class_ * width - 1e-9 <= cost < (class_ + 1) * width + 1e-9
    assert abs(class_centres()[class_] - cost) <= width / 2 + 1e-4


def test_each_centre_is_of_its_own_class():
    np.testing.assert_array_equal(cost_to_class(class_centres()), np.arange(13))


def test_softmax_against_its_definition():
    logits = np.random.default_rng(0).normal(0, 3, (2, 14, 5, 5))
    np.testing.assert_allclose(
        softmax(logits, axis=1), np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True), rtol=1e-4
    )


def test_softmax_of_large_logits_is_finite_and_ignores_a_shift():
    logits = np.random.default_rng(0).normal(0, 3, (14, 6)).astype(np.float32)
    np.testing.assert_allclose(softmax(logits + 1024, axis=0), softmax(logits, axis=0), atol=1e-4)


def test_expected_cost_is_the_mean_over_all_classes_on_even_ground():
    """Where all cells are alike, the neighbourhood adds no doubt."""
    probabilities = softmax(np.random.default_rng(1).normal(0, 2, (3, 14, 1, 1)), axis=1)
    found = expected_cost(np.broadcast_to(probabilities, (3, 14, 4, 4)))
    costs = [*class_centres(), 255]
    for n, i, j in np.ndindex(3, 4, 4):
        assert found[n, i, j] == pytest.approx(np.average(costs, weights=probabilities[n, :, 0, 0]), rel=1e-5)


def test_doubtful_neighbours_make_a_cell_dearer_and_sure_ones_no_cheaper():
    probabilities = softmax(np.random.default_rng(2).normal(0, 2, (14, 9, 9)), axis=0)
    found = expected_cost(probabilities)
    centres, p = class_centres(), probabilities[13]
    for i, j in np.ndindex(9, 9):
        window = [p[min(max(i + a, 0), 8), min(max(j + b, 0), 8)] for a in (-1, 0, 1) for b in (-1, 0, 1)]
        doubt = max(p[i, j], np.mean(window))
        if_feasible = np.average(centres, weights=probabilities[:13, i, j])
        assert found[i, j] == pytest.approx((1 - doubt) * if_feasible + doubt * 255, rel=1e-4)


def test_certainty_costs_its_class():
    for class_, cost in enumerate([*class_centres(), 255]):
        probabilities = np.zeros((14, 1, 1))
        probabilities[class_] = 1
        assert expected_cost(probabilities)[0, 0] == pytest.approx(cost, rel=1e-6)


@given(unit, unit)
def test_doubt_makes_a_cell_dearer(low, high):
    low, high = sorted((low, high))
    costs = []
    for infeasible in (low, high):
        probabilities = np.zeros((14, 1, 1))
        probabilities[4], probabilities[13] = 1 - infeasible, infeasible
        costs.append(expected_cost(probabilities)[0, 0])
    assert costs[0] <= costs[1]
