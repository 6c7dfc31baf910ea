"""Cell and pick metrics: small cases by hand, and a loop over single cells as the reference."""

import numpy as np
import pytest

from footsel.footholds.cost import cost_to_class
from footsel.footholds.metrics import CellMetrics, PickMetrics
from footsel.footholds.reasons import Reason


def test_cells_by_hand():
    # Six cells: a hit in class 0, a wrong class, a false unsafe, a false safe, a hit in 13, an unknown one.
    cost = np.array([[10, 30, 50, 255, 255, 255]])
    reason = np.array(
        [[Reason.FEASIBLE] * 3 + [Reason.TERRAIN_COLLISION, Reason.KINEMATIC_RANGE, Reason.UNKNOWN]], dtype=np.uint8
    )
    metrics = CellMetrics()
    metrics.update(
        predicted_class=np.array([[0, 2, 13, 1, 13, 0]]),
        predicted_cost=np.array([[12.0, 40.0, 255.0, 20.0, 255.0, 0.0]]),
        predicted_feasible=np.array([[True, True, False, True, False, True]]),
        oracle_cost=cost,
        oracle_reason=reason,
    )
    result = metrics.result()
    assert result["accuracy"] == pytest.approx(2 / 5)
    assert result["accuracy_feasible"] == pytest.approx(1 / 3)
    assert result["cost_mae"] == pytest.approx((2 + 10) / 2)
    # Truth 0, 1, 2, 13, 13 against 0, 2, 13, 1, 13: class 0 hits 1 of 1, 13 hits 1 of a union of 3, 1 and 2 none.
    assert result["miou"] == pytest.approx((1 + 1 / 3) / 14)
    assert result["miou_present"] == pytest.approx((1 + 1 / 3) / 4)
    assert result["false_safe_rate"] == pytest.approx(1 / 2)
    assert result["false_unsafe_rate"] == pytest.approx(1 / 3)
    assert result["recall_by_reason"] == {
        "FEASIBLE": pytest.approx(2 / 3),
        "KINEMATIC_RANGE": 1.0,
        "SELF_COLLISION": None,
        "TERRAIN_COLLISION": 0.0,
    }


def test_nothing_seen_gives_none_and_never_a_number():
    result = CellMetrics().result()
    by_reason = result.pop("recall_by_reason"), result.pop("cells_by_reason")
    assert set(result.values()) == {None}
    assert [set(values.values()) for values in by_reason] == [{None}, {0}]
    picks = PickMetrics().result()
    assert picks["picks"] == picks["none"] == 0
    assert (
        picks["infeasible_rate"] is None
        and picks["missed_rate"] is None
        and picks["regret_mean"] is None
        and picks["regret_p95"] is None
    )


def test_cells_equal_a_loop_over_single_cells():
    rng = np.random.default_rng(3)
    shape = (4, 12, 12)
    reason = rng.integers(0, len(Reason), shape).astype(np.uint8)
    cost = np.where(reason == Reason.FEASIBLE, rng.integers(0, 200, shape), 255).astype(np.uint8)
    classes = rng.integers(0, 12, shape)  # one class is never predicted and two never occur
    predicted_cost = rng.uniform(0, 255, shape)
    feasible = rng.random(shape) < 0.6
    metrics = CellMetrics()
    for part in (slice(0, 1), slice(1, 4)):
        metrics.update(classes[part], predicted_cost[part], feasible[part], cost[part], reason[part])

    known = [index for index in np.ndindex(shape) if reason[index] != Reason.UNKNOWN]
    truth = {index: int(cost_to_class(cost[index])) for index in known}
    good = [index for index in known if reason[index] == Reason.FEASIBLE]
    bad = [index for index in known if reason[index] != Reason.FEASIBLE]
    ious, present = [], []
    for label in range(14):
        hit = sum(truth[i] == label and classes[i] == label for i in known)
        union = sum(truth[i] == label or classes[i] == label for i in known)
        ious.append(hit / union if union else 0.0)
        if union:
            present.append(hit / union)
    result = metrics.result()
    assert result["accuracy"] == pytest.approx(np.mean([truth[i] == classes[i] for i in known]))
    assert result["accuracy_feasible"] == pytest.approx(np.mean([truth[i] == classes[i] for i in good]))
    assert result["cost_mae"] == pytest.approx(np.mean([abs(predicted_cost[i] - cost[i]) for i in good if feasible[i]]))
    assert result["miou"] == pytest.approx(np.mean(ious))
    assert result["miou_present"] == pytest.approx(np.mean(present))
    assert len(present) == 13
    assert result["false_safe_rate"] == pytest.approx(np.mean([feasible[i] for i in bad]))
    assert result["false_unsafe_rate"] == pytest.approx(np.mean([not feasible[i] for i in good]))
    for name, share in result["recall_by_reason"].items():
        cells = [i for i in known if reason[i] == Reason[name]]
        assert share == pytest.approx(np.mean([feasible[i] == (name == "FEASIBLE") for i in cells]))
        assert result["cells_by_reason"][name] == len(cells)


def test_picks_by_hand():
    final = np.full((5, 2, 2), np.inf)
    final[0] = [[10, 20], [30, np.inf]]
    final[1, 0, 0] = 5
    final[2, 0, 1] = 7
    reason = np.where(np.isfinite(final), Reason.FEASIBLE, Reason.KINEMATIC_RANGE)
    reason[1, 1, 0] = Reason.TERRAIN_COLLISION
    reason[3, 1, 1] = Reason.UNKNOWN
    metrics = PickMetrics()
    # Regret 10; infeasible; missed; on an unknown cell where the oracle has none; rightly none.
    metrics.update([[0, 1], [1, 0], [-1, -1]], final[:3], reason[:3])
    metrics.update([[1, 1], [-1, -1]], final[3:], reason[3:])
    metrics.update([[0, 0]], final[:1], reason[:1])  # the best cell: regret 0
    assert metrics.result() == {
        "picks": 4,
        "none": 2,
        "missed": 1,
        "missed_rate": 0.25,
        "infeasible_picks": 2,
        "infeasible_by_reason": {"UNKNOWN": 1, "KINEMATIC_RANGE": 0, "SELF_COLLISION": 0, "TERRAIN_COLLISION": 1},
        "unknown_picks": 1,
        "infeasible_rate": 0.5,
        "regret_mean": 5.0,
        "regret_p95": pytest.approx(9.5),
    }
