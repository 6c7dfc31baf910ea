"""The comparison's figures: its contract, the oracle's perfection, and a recount that shares only the labels."""

import json
from copy import deepcopy

import numpy as np
import pytest

from footsel.comparison.compare import compare
from footsel.comparison.maps import NamedMap, built_in_courses
from footsel.comparison.poses import draw_poses
from footsel.errors import InputError, MapError, ModelError
from footsel.footholds import REASON_NAMES, LegLayout
from footsel.footholds.metrics import CellMetrics
from footsel.legs import LEGS
from footsel.oracle import Oracle
from footsel.runtime import FootholdSelector
from footsel.terrain.courses import FAMILIES

PICK_KEYS = {
    "picks", "none", "missed", "infeasible_picks", "unknown_picks", "infeasible_rate", "regret_mean", "regret_p95",
    "missed_rate", "infeasible_by_reason", "time_ms",
}  # fmt: skip
CELL_KEYS = {
    "accuracy", "accuracy_feasible", "cost_mae", "miou", "miou_present", "false_safe_rate", "false_unsafe_rate",
    "recall_by_reason", "cells_by_reason",
}  # fmt: skip


@pytest.fixture(scope="module")
def figures(comparison):
    return comparison.figures()


@pytest.fixture(scope="module")
def labels(comparison):
    """(map index, leg, local map, label, nominal xy, pose) of every question, made anew."""
    oracle = Oracle.load("anymal_b")
    layout = oracle.robot.layout
    found = []
    for index, named in enumerate(comparison.maps):
        rng = np.random.default_rng([comparison.seed, index])
        for pose in draw_poses(rng, named.elevation_map, layout, comparison.poses):
            for leg in LEGS:
                local_map = layout.local_map(named.elevation_map, pose, leg)
                label = oracle.label(local_map, leg, pose.roll, pose.pitch)
                found.append((index, leg, local_map, label, layout.nominal_xy(leg, pose), pose))
    return found


def without_times(figures):
    """The figures that a seed fixes."""
    kept = deepcopy(figures)
    for part in (kept, *kept["per_map"].values()):
        for picks in part["selectors"].values():
            del picks["time_ms"]
    return kept


def test_the_contract(figures, comparison):
    assert figures["robot"] == "anymal_b"
    assert figures["poses"] == comparison.poses
    assert figures["maps"] == ["stairs", "rubble"]
    assert list(figures["selectors"]) == ["oracle", "cnn", "cnn+verify", "terrain_only", "nominal"]
    for picks in figures["selectors"].values():
        assert set(picks) == PICK_KEYS
        assert 0 < picks["time_ms"]["p50"] <= picks["time_ms"]["p99"]
        assert picks["picks"] + picks["none"] == 2 * comparison.poses * 4
    assert set(figures["cells"]) == {"cnn"}
    assert set(figures["cells"]["cnn"]) == CELL_KEYS
    assert set(figures["cells"]["cnn"]["recall_by_reason"]) == set(REASON_NAMES) - {"UNKNOWN"}
    json.dumps(figures, allow_nan=False)


def test_parts_add_up(figures):
    stairs = figures["per_map"]["stairs"]
    for whole, parts in ((figures, figures["per_map"]), (figures, figures["per_leg"]), (stairs, stairs["legs"])):
        for name, picks in whole["selectors"].items():
            for key in ("picks", "none", "missed", "infeasible_picks", "unknown_picks"):
                assert picks[key] == sum(part["selectors"][name][key] for part in parts.values())
        assert whole["asked"] == sum(part["asked"] for part in parts.values())
    for part in figures["per_map"].values():
        assert sum(part["reason_shares"].values()) == pytest.approx(1)
    for name, reasons in figures["infeasible_pick_reasons"].items():
        assert sum(reasons.values()) == figures["selectors"][name]["infeasible_picks"]


def test_the_oracle_is_perfect_and_nobody_picks_unknown_cells(figures, labels):
    oracle = figures["selectors"]["oracle"]
    assert oracle["missed"] == oracle["infeasible_picks"] == oracle["regret_mean"] == oracle["regret_p95"] == 0
    assert oracle["picks"] == figures["answerable"] == sum(label.feasible.any() for *_, label, _, _ in labels)
    assert all(picks["unknown_picks"] == 0 for picks in figures["selectors"].values())
    assert figures["selectors"]["cnn+verify"]["infeasible_picks"] == 0
    assert figures["selectors"]["cnn"]["infeasible_picks"] > 0


def test_nominal_is_recounted_cell_by_cell(figures, labels):
    picks = none = missed = infeasible = 0
    regrets = []
    for _, _, local_map, label, nominal, _ in labels:
        positions = local_map.positions()
        nearest, best = None, np.inf
        for i in range(40):
            for j in range(40):
                away = np.hypot(positions[i, j, 0] - nominal[0], positions[i, j, 1] - nominal[1])
                if nearest is None or away < nearest[0]:
                    nearest = (away, i, j)
                if label.reason[i, j] == 0:
                    best = min(best, label.cost[i, j] + 160 * away)
        away, i, j = nearest
        if np.isnan(local_map.heights[i, j]):
            none += 1
            missed += best < np.inf
            continue
        picks += 1
        if label.reason[i, j] != 0:
            infeasible += 1
        else:
            regrets.append(label.cost[i, j] + 160 * away - best)
    counted = figures["selectors"]["nominal"]
    assert min(picks, none, infeasible, len(regrets)) > 0
    assert (counted["picks"], counted["none"], counted["missed"]) == (picks, none, missed)
    assert counted["infeasible_picks"] == infeasible
    assert counted["infeasible_rate"] == pytest.approx(infeasible / picks)
    assert counted["regret_mean"] == pytest.approx(np.mean(regrets))
    assert counted["regret_p95"] == pytest.approx(np.percentile(regrets, 95))


def test_the_networks_cells_are_those_of_evaluate(figures, labels, model):
    runtime = FootholdSelector.load(model)
    metrics = CellMetrics()
    for _, leg, local_map, label, _, pose in labels:
        cells = runtime.evaluate(local_map.heights, leg, pose.roll, pose.pitch)
        metrics.update(cells.class_, cells.cost, cells.feasible, label.cost, label.reason)
    expected = metrics.result()
    for key in CELL_KEYS - {"recall_by_reason"}:
        assert figures["cells"]["cnn"][key] == pytest.approx(expected[key])


def test_the_same_seed_gives_the_same_figures_whatever_the_jobs(comparison, figures, maps, model):
    names = tuple(comparison.contestants.selectors)
    again = compare(maps, names, poses=comparison.poses, seed=comparison.seed, jobs=2, model=model)
    assert without_times(again.figures()) == without_times(figures)
    other = compare(maps, ("oracle",), poses=comparison.poses, seed=comparison.seed + 1)
    assert other.figures()["reason_shares"] != figures["reason_shares"]


def test_what_cannot_be_compared_is_refused(maps, handmade, tmp_path, anymal_layout: LegLayout):
    with pytest.raises(InputError, match="twice"):
        compare([maps[0], maps[0]], ["nominal"])
    with pytest.raises(InputError, match="no map"):
        compare([], ["nominal"])
    unknown = NamedMap("dark", type(maps[0].elevation_map)(np.full((20, 20), np.nan), 0.02))
    with pytest.raises(MapError, match="dark: has no place with known ground"):
        compare([unknown], ["nominal"])
    # A layout that is right to the centimetre only is that of another robot.
    contracts = {pair: handmade.contract(anymal_layout, pair) for pair in ("front", "hind")}
    files = {f"{pair}.onnx": handmade.constant_model(contract) for pair, contract in contracts.items()}
    with pytest.raises(ModelError, match="another description"):
        compare(maps, ["cnn"], model=handmade.write_folder(tmp_path / "foreign", files))


def test_there_is_one_fresh_course_per_family():
    courses = built_in_courses(0)
    assert [named.name for named in courses] == list(FAMILIES)
    again, other = built_in_courses(0), built_in_courses(1)
    stairs = list(FAMILIES).index("stairs")
    np.testing.assert_array_equal(courses[stairs].elevation_map.elevation, again[stairs].elevation_map.elevation)
    assert (courses[stairs].elevation_map.elevation != other[stairs].elevation_map.elevation).any()
