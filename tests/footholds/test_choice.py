"""The choice of a cell, against a plain search."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footsel.footholds import CellScores, Reason, choose
from footsel.footholds.choice import DISTANCE_WEIGHT, final_costs, ranked_cells
from footsel.terrain import LocalMap

NOMINAL = (0.21, -0.13, -0.5)


def random_case(seed: int) -> tuple[CellScores, LocalMap]:
    rng = np.random.default_rng(seed)
    heights = rng.uniform(-0.6, -0.4, (12, 12))
    heights[rng.random(heights.shape) < 0.3] = np.nan
    # Whole costs, so that there are ties.
    scores = CellScores(rng.integers(0, 6, heights.shape) * 20.0, rng.random(heights.shape) < 0.5)
    return scores, LocalMap(heights, 0.02, np.array([0.2, -0.1, 0.0]), rng.uniform(-3, 3))


def plain_ranking(scores, local_map, nominal, k=DISTANCE_WEIGHT):
    """(final cost, d_n, cell) of all cells that may be chosen, in order."""
    positions = local_map.positions()
    candidates = []
    for cell in np.ndindex(scores.cost.shape):
        if scores.feasible[cell] and np.isfinite(local_map.heights[cell]):
            d = float(np.hypot(*(positions[cell][:2] - nominal[:2])))
            candidates.append((scores.cost[cell] + k * d, d, cell))
    return sorted(candidates)


@pytest.mark.parametrize("seed", range(20))
def test_choice_and_alternatives_are_those_of_a_plain_search(seed):
    scores, local_map = random_case(seed)
    ranking = plain_ranking(scores, local_map, NOMINAL)
    foothold = choose(scores, local_map, NOMINAL, top_k=5)
    total, distance, cell = ranking[0]
    assert foothold.status == "ok"
    assert foothold.reason is None
    assert foothold.final_cost == pytest.approx(total)
    assert foothold.distance_to_nominal == pytest.approx(distance)
    assert foothold.cell == cell
    assert foothold.cost == scores.cost[cell]
    assert foothold.class_ == int(scores.cost[cell] * 13 // 255)
    np.testing.assert_allclose(foothold.position, local_map.positions()[cell])
    assert [a.final_cost for a in foothold.alternatives] == pytest.approx([entry[0] for entry in ranking[1:5]])


@pytest.mark.parametrize("seed", range(5))
def test_another_distance_weight(seed):
    scores, local_map = random_case(seed)
    for k in (0.0, 1.0, 1e4):
        foothold = choose(scores, local_map, NOMINAL, distance_weight=k)
        assert foothold.final_cost == pytest.approx(plain_ranking(scores, local_map, NOMINAL, k)[0][0])


def test_equal_costs_go_to_the_nearest_cell():
    local_map = LocalMap(np.full((40, 40), -0.5), 0.02, np.zeros(3), 0.3)
    scores = CellScores(np.full((40, 40), 77.0), np.ones((40, 40), dtype=bool))
    foothold = choose(scores, local_map, NOMINAL)
    assert foothold.distance_to_nominal == pytest.approx(local_map.distances_to(NOMINAL[:2]).min())


def test_equal_final_costs_go_to_the_nearer_cell():
    total = np.array([[5.0, 5.0], [5.0, np.inf]])
    distances = np.array([[0.3, 0.1], [0.2, 0.0]])
    np.testing.assert_array_equal(ranked_cells(total, distances, 1), [[0, 1]])
    np.testing.assert_array_equal(ranked_cells(total, distances, 9), [[0, 1], [1, 0], [0, 0]])


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 150))
def test_the_first_of_a_ranking_do_not_depend_on_its_length(seed, most):
    scores, local_map = random_case(seed)
    total = final_costs(scores, local_map, np.array(NOMINAL[:2]))
    distances = local_map.distances_to(NOMINAL[:2])
    everything = ranked_cells(total, distances, total.size)
    assert len(everything) == np.isfinite(total).sum()
    np.testing.assert_array_equal(ranked_cells(total, distances, most), everything[:most])


def test_no_answer_says_why():
    heights = np.full((40, 40), -0.5)
    nothing = np.zeros((40, 40), dtype=bool)
    local_map, unknown = (LocalMap(h, 0.02, np.zeros(3), 0.0) for h in (heights, heights * np.nan))
    cost = np.zeros((40, 40))
    assert choose(CellScores(cost, nothing), local_map, NOMINAL).reason == "no known cell is feasible"
    assert choose(CellScores(cost, nothing, "too steep"), local_map, NOMINAL).reason == "too steep"
    everything_unknown = choose(CellScores(cost, ~nothing), unknown, NOMINAL)
    assert everything_unknown.reason == "no cell of the local map is known"
    refused = choose(CellScores(cost, ~nothing), local_map, NOMINAL, verify=lambda *_: False)
    assert refused.reason == "none of 1600 candidates passed the verification"
    for foothold in (everything_unknown, refused):
        values = foothold.to_dict()
        assert values["status"] == "none"
        assert values["nominal"] == list(NOMINAL)
        assert values["alternatives"] == []
        numbers = ("position", "cell", "cost", "class", "final_cost", "distance_to_nominal", "confidence")
        assert {values[key] for key in numbers} == {None}


def test_the_confidence_is_that_of_the_chosen_cell():
    scores, local_map = random_case(4)
    assert choose(scores, local_map, NOMINAL).confidence is None
    confidence = np.random.default_rng(9).random(scores.cost.shape)
    foothold = choose(replace(scores, confidence=confidence), local_map, NOMINAL)
    assert foothold.confidence == foothold.to_dict()["confidence"] == confidence[foothold.cell]


def test_verify_is_asked_in_order_and_no_longer_than_needed():
    scores, local_map = random_case(3)
    ranking = plain_ranking(scores, local_map, NOMINAL)
    asked = []

    def verify(cell, position):
        asked.append((cell, position))
        return len(asked) % 3 == 0

    foothold = choose(scores, local_map, NOMINAL, top_k=2, verify=verify)
    assert len(asked) == 6
    assert [local_map.distances_to(NOMINAL[:2])[cell] for cell, _ in asked] == pytest.approx(
        [r[1] for r in ranking[:6]]
    )
    assert foothold.final_cost == pytest.approx(ranking[2][0])
    assert foothold.alternatives[0].final_cost == pytest.approx(ranking[5][0])
    assert all(isinstance(index, int) for cell, _ in asked for index in cell)


def test_reasons_keep_their_numbers():
    """They are stored in labels and data sets."""
    assert [(reason.name, reason.value) for reason in Reason] == [
        ("FEASIBLE", 0),
        ("UNKNOWN", 1),
        ("KINEMATIC_RANGE", 2),
        ("SELF_COLLISION", 3),
        ("TERRAIN_COLLISION", 4),
    ]
