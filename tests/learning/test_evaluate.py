"""Judging: picks as the runtime makes them, decoding as the runtime does, the threshold's rule, families."""

from dataclasses import replace

import numpy as np
import pytest

from footsel.comparison.poses import TILT
from footsel.footholds import BasePose, CellScores, Reason, choose
from footsel.footholds.cost import CLASSES, softmax
from footsel.learning.degraded import Degradation
from footsel.learning.evaluate import evaluate
from footsel.learning.loss import LABEL_CLASS
from footsel.learning.picks import final_cost_maps, nominal_distances, pick_cells, picks_below
from footsel.learning.predictions import predict_all
from footsel.learning.scores import Judgement
from footsel.learning.threshold import THRESHOLDS, USUAL_TILT, at_missed, choose_feasible_below, threshold_curve, usual
from footsel.runtime.evaluation import decode
from footsel.terrain import LocalMap


def random_predict(samples):
    logits = np.random.default_rng(0).normal(0, 3, (len(samples), CLASSES, 40, 40))
    return softmax(logits, axis=1)


def perfect_predict(samples):
    probabilities = np.eye(CLASSES, dtype=np.float32)[LABEL_CLASS[samples.cost]]
    return np.moveaxis(probabilities, -1, 1)


@pytest.mark.parametrize("leg", ["LF", "LH"])
def test_picks_equal_choose(samples, layout, leg):
    rng = np.random.default_rng(8)
    cost = rng.integers(0, 3, samples.cost.shape) * 10.0  # few values, so that ties happen
    feasible = rng.random(samples.cost.shape) < 0.4
    feasible[3] = False
    known = samples.reason != Reason.UNKNOWN
    distances = nominal_distances(layout, leg, samples.roll, samples.pitch)
    cells = pick_cells(final_cost_maps(cost, feasible & known, distances), distances)
    for n in range(len(samples)):
        x, y, z, yaw = 3.0, -1.0, 0.5, 0.0
        pose = BasePose(x, y, z, float(samples.roll[n]), float(samples.pitch[n]), yaw)
        local_map = LocalMap(samples.heights()[n], layout.resolution, layout.hip_position(leg, pose), yaw)
        nominal = layout.nominal_xy(leg, pose)
        np.testing.assert_allclose(local_map.distances_to(nominal), distances[n], atol=1e-9)
        foothold = choose(CellScores(cost[n], feasible[n]), local_map, (*nominal.tolist(), 0.0))
        assert foothold.cell == (None if n == 3 else tuple(cells[n].tolist()))
    assert (cells[3] == -1).all()


def test_equal_final_costs_go_to_the_nearer_cell():
    distances = np.array([[[0.2, 0.1], [0.1, 0.3]]])
    final = np.array([[[5.0, 5.0], [5.0, 6.0]]])
    assert pick_cells(final, distances).tolist() == [[0, 1]]


@pytest.mark.parametrize("feasible_below", [0.5, 0.05])
def test_decoding_equals_the_runtimes(samples, feasible_below):
    predictions = predict_all(random_predict, samples)
    runtime = decode(random_predict(samples), samples.reason != Reason.UNKNOWN, feasible_below)
    ours = predictions.decode(feasible_below)
    np.testing.assert_array_equal(ours.class_, runtime.class_)
    np.testing.assert_array_equal(ours.cost, runtime.cost)
    np.testing.assert_array_equal(ours.feasible, runtime.feasible)
    assert runtime.feasible.any() and not runtime.feasible.all()


def test_cross_entropy_equals_torchs(samples):
    torch = pytest.importorskip("torch")
    weights = np.linspace(1, 3, CLASSES, dtype=np.float32)
    expected = torch.nn.functional.nll_loss(
        torch.log(torch.from_numpy(random_predict(samples))),
        torch.from_numpy(LABEL_CLASS[samples.cost].astype(np.int64)),
        torch.from_numpy(weights),
    )
    got = predict_all(random_predict, samples).cross_entropy(samples, weights)
    assert got == pytest.approx(float(expected), rel=1e-5)


def test_a_perfect_network_has_perfect_figures(samples, layout):
    figures = evaluate(perfect_predict, samples, layout, "LF", 0.5)
    assert set(figures["families"]) == {"steps", "blocks"}
    everything = figures["all"]
    assert everything["maps"] == 10 and everything["cells"]["accuracy"] == 1.0
    assert everything["cells"]["false_safe_rate"] == everything["cells"]["false_unsafe_rate"] == 0.0
    assert everything["cells"]["miou_present"] == everything["cells_likeliest"]["miou_present"] == 1.0
    assert everything["picks"]["picks"] == 10 and everything["picks"]["infeasible_picks"] == 0
    # Class centres stand for whole bins, so a pick can still be dearer than the best by a bin.
    assert 0 <= everything["picks"]["regret_mean"] < 255 / 13


def test_families_add_up_to_all(samples, layout):
    figures = evaluate(random_predict, samples.take(slice(0, 5)), layout, "LF", 0.05)
    maps = [family["maps"] for family in figures["families"].values()]
    picks = [family["picks"]["picks"] for family in figures["families"].values()]
    assert maps == [2, 3] and sum(picks) == figures["all"]["picks"]["picks"]


def test_lower_thresholds_call_fewer_cells_feasible(samples, layout):
    curve = threshold_curve(predict_all(random_predict, samples), samples, layout, "LF")
    assert [point["feasible_below"] for point in curve] == list(THRESHOLDS)
    false_safe = [point["false_safe_rate"] for point in curve]
    false_unsafe = [point["false_unsafe_rate"] for point in curve]
    assert false_safe == sorted(false_safe, reverse=True) and false_safe[0] > false_safe[-1]
    assert false_unsafe == sorted(false_unsafe)
    # The same figures as the evaluation at that threshold.
    for at in (curve[0], curve[12], curve[-1]):
        figures = evaluate(random_predict, samples, layout, "LF", at["feasible_below"])["all"]
        assert at["false_safe_rate"] == pytest.approx(figures["cells"]["false_safe_rate"])
        assert at["false_unsafe_rate"] == pytest.approx(figures["cells"]["false_unsafe_rate"])
        assert {key: at[key] for key in figures["picks"]} == figures["picks"]


def test_the_curve_and_the_scores_do_not_depend_on_how_maps_come(samples, layout, flat):
    predictions = predict_all(random_predict, samples)
    whole, parts = (Judgement(layout, "LF", 0.05) for _ in range(2))
    whole.update(predictions, samples)
    for part in (slice(0, 3), slice(3, 10)):
        parts.update(predictions.take(part), samples.take(part))
    assert flat(whole.result()) == pytest.approx(flat(parts.result()))


def test_picks_below_a_threshold_are_the_picks_of_the_cells_below_it(samples, layout):
    rng = np.random.default_rng(8)
    known = samples.reason != Reason.UNKNOWN
    distances = np.round(nominal_distances(layout, "LF", samples.roll, samples.pitch), 1)
    # Costs and distances of few values, so that cells tie, nearer and farther ones too: 0.1 m weighs 16.
    final = final_cost_maps(rng.integers(0, 4, samples.cost.shape) * 16.0, known, distances)
    infeasible = rng.random(samples.cost.shape, dtype=np.float32)
    best = pick_cells(final, distances)
    at_the_edge = float(infeasible[0][tuple(best[0])])
    thresholds = (1.0, at_the_edge, 0.9, 0.004, 0.0005, 0.0)
    picks = picks_below(final, distances, infeasible, thresholds)
    for threshold, cells in zip(thresholds, picks, strict=True):
        below = np.where(infeasible < np.float32(threshold), final, np.inf)
        np.testing.assert_array_equal(cells, pick_cells(below, distances))
    np.testing.assert_array_equal(picks[0], best)
    assert (picks[1, 0] != best[0]).any() and (picks[-1] == -1).all() and picks[4].max() > -1


def test_a_cell_at_a_threshold_is_not_below_it(samples, layout):
    predictions = predict_all(random_predict, samples)
    infeasible = np.random.default_rng(3).choice(np.array(THRESHOLDS, dtype=np.float32), samples.cost.shape)
    predictions = replace(predictions, infeasible=infeasible)
    for point in threshold_curve(predictions, samples, layout, "LF")[::6]:
        called = predictions.feasible(point["feasible_below"])
        feasible = samples.reason == Reason.FEASIBLE
        assert point["false_unsafe_rate"] == pytest.approx((feasible & ~called).sum() / feasible.sum())


def test_degraded_maps_do_not_depend_on_how_many_come_at_once(samples, layout, monkeypatch, flat):
    worse = Degradation("d435", 0.2, 1)
    together = evaluate(random_by_height, samples, layout, "LF", 0.2, worse)
    monkeypatch.setattr("footsel.learning.evaluate.CHUNK", 3)
    assert flat(evaluate(random_by_height, samples, layout, "LF", 0.2, worse)) == pytest.approx(flat(together))


def random_by_height(samples):
    """Probabilities that depend on each cell's height alone."""
    phase = np.nan_to_num(samples.heights())[:, None] * np.linspace(20, 300, CLASSES)[:, None, None]
    return softmax(3 * np.sin(phase), axis=1)


def test_the_threshold_keeps_best_to_both_limits():
    def point(threshold, infeasible, missed):
        return {"feasible_below": threshold, "infeasible_rate": infeasible, "missed_rate": missed}

    # 0.7 % of infeasible picks weigh as much as 0.5 % of missed footholds, and the one further off more than the other.
    assert choose_feasible_below([point(0.5, 0.02, 0), point(0.2, 0.01, 0.0065), point(0.1, 0.0, 0.01)]) == 0.2
    assert choose_feasible_below([point(0.5, 0.02, 0), point(0.2, 0.01, 0.0105), point(0.1, 0.0, 0.01)]) == 0.1
    # The worse of the two is all but the same, the other is not.
    assert choose_feasible_below([point(0.5, 0.0103, 0.0068), point(0.2, 0.0101, 0.0085)]) == 0.5
    # As good: fewer infeasible picks, and then no cell forbidden for nothing.
    assert choose_feasible_below([point(0.5, 0.007, 0.005), point(0.2, 0.005, 0.005), point(0.1, 0.005, 0.005)]) == 0.2
    # Nothing picked at all, or nothing to pick, has no rate.
    assert choose_feasible_below([point(0.5, None, None), point(0.2, None, None)]) == 0.5


def test_a_picked_cells_confidence_is_judged_by_what_the_oracle_says_of_it(samples, layout):
    """A network sure of everything, right or wrong, is overconfident by just the share of its infeasible picks."""

    def sure(samples):
        probabilities = np.full((len(samples), CLASSES, 40, 40), 0.01 / 13, dtype=np.float32)
        probabilities[:, 0] = 0.99 - 0.01 * 12 / 13
        probabilities[:, 13] = 0.01
        return probabilities

    figures = evaluate(sure, samples, layout, "LF", 0.5)["all"]
    picks, calibration = figures["picks"], figures["calibration"]
    assert picks["picks"] == 10 and sum(each["count"] for each in calibration["picks"]["bins"]) == 10
    assert calibration["picks"]["ece"] == pytest.approx(abs(0.99 - (1 - picks["infeasible_rate"])), abs=1e-6)
    shares = samples.reason[samples.reason != Reason.UNKNOWN] != Reason.FEASIBLE
    assert calibration["infeasible"]["ece"] == pytest.approx(shares.mean() - 0.01, abs=1e-6)
    zero = (LABEL_CLASS[samples.cost] == 0)[samples.reason != Reason.UNKNOWN].mean()
    assert calibration["likeliest"]["ece"] == pytest.approx(abs(0.99 - 0.01 * 12 / 13 - zero), abs=1e-5)


def test_networks_are_compared_where_they_miss_equally_much():
    def point(missed, infeasible, regret):
        return {"missed_rate": missed, "infeasible_rate": infeasible, "regret_mean": regret}

    curve = [point(0.0, 0.3, 1.0), point(0.0, 0.2, 2.0), point(0.04, 0.1, 6.0), point(0.04, 0.05, 7.0)]
    assert at_missed(curve, 0.01) == pytest.approx({"infeasible_rate": 0.175, "regret_mean": 3.0})
    assert at_missed(curve, 0.04) == {"infeasible_rate": 0.1, "regret_mean": 6.0}
    assert at_missed(curve, 0.05) is None and at_missed(curve[2:], 0.01) is None
    assert at_missed([*curve, point(1.0, None, None)], 0.05) is None  # Nothing is picked there.


def test_a_threshold_is_chosen_for_bases_that_are_not_tilted_far(samples):
    pose = samples.pose.copy()
    pose[:, 3:5] = 0
    pose[1, 3], pose[2, 4], pose[3, 3:5] = -1.01 * USUAL_TILT, 1.01 * USUAL_TILT, 0.99 * USUAL_TILT
    assert np.flatnonzero(~usual(replace(samples, pose=pose))).tolist() == [1, 2]
    pose[:, 4] = 0.25
    assert usual(replace(samples, pose=pose)).all()
    assert pytest.approx(TILT) == USUAL_TILT  # As far as `footsel compare` tilts it.
