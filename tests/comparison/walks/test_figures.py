"""Rates, means and paired differences against their definitions."""

import json

import numpy as np
import pytest

from footsel.comparison.walks.figures import COMPARED, METRICS, figures, paired_differences
from footsel.comparison.walks.statistics import wilson_interval


def test_runs_stand_in_their_order_with_the_contracts_names(results):
    values = figures(results)
    json.dumps(values, allow_nan=False)
    assert [(r["terrain"], r["selector"], r["seed"]) for r in values["runs"]] == [
        (r.terrain, r.selector, r.seed) for r in results
    ]
    for name in ("success", "reason", "distance_m", "slip_max_mm", "shank_impacts", "realtime_factor", "map"):
        assert name in values["runs"][0]
    assert list(values["summary"]) == ["stairs", "stones"]
    assert list(values["summary"]["stones"]) == ["oracle", "cnn", "nominal"]


def test_rates_and_means(results):
    part = figures(results)["summary"]["stones"]["nominal"]
    runs = [r for r in results if r.terrain == "stones" and r.selector == "nominal"]
    assert part["n"] == 10 and part["success_rate"] == 0.1
    assert part["ci95"] == list(wilson_interval(1, 10))
    assert part["failures"] == {"the base touched the ground": 9}
    for metric in METRICS:
        assert part["means"][metric] == pytest.approx(np.mean([getattr(r, metric) for r in runs]))
    assert part["means_of_successes"]["distance_m"] == 4.5


def test_failures_are_counted_by_their_kind(result):
    reasons = ("fell (RH_KFE touched the ground)", "fell within 3 s", "stopped: none for LF", "")
    runs = [result(seed=seed, success=not reason, reason=reason) for seed, reason in enumerate(reasons)]
    assert figures(runs)["summary"]["stairs"]["cnn"]["failures"] == {"fell": 2, "stopped": 1}


def test_pairs_are_of_one_seed_and_of_walks_that_both_finished(result):
    ours = [result(seed=s, slip_max_mm=10.0 + s, success=s != 3) for s in (0, 1, 2, 3)]
    theirs = [result(selector="nominal", seed=s, slip_max_mm=30.0, success=s != 1) for s in (3, 2, 1, 7)]
    difference = paired_differences(ours, theirs)
    assert difference["success"]["pairs"] == 3
    assert difference["success"]["mean"] == pytest.approx((1 + 0 - 1) / 3)
    # Seed 2 alone was finished by both.
    assert difference["slip_max_mm"]["pairs"] == 1
    assert difference["slip_max_mm"]["mean"] == pytest.approx(12 - 30)
    back = paired_differences(theirs, ours)
    for metric in ("success", *COMPARED):
        assert back[metric]["mean"] == pytest.approx(-difference[metric]["mean"])


def test_nobody_finished_leaves_no_difference(result):
    ours = [result(seed=0, success=False)]
    assert paired_differences(ours, [result(selector="nominal", seed=0)])["slip_max_mm"] is None
    assert figures(ours)["summary"]["stairs"]["cnn"]["means_of_successes"] is None


def test_the_oracle_is_the_reference_and_the_network_has_rivals(results):
    values = figures(results)
    assert "minus_oracle" not in values["summary"]["stairs"]["oracle"]
    scraped = values["summary"]["stairs"]["nominal"]["minus_oracle"]["hind_shank_contact_s"]
    assert scraped["mean"] == pytest.approx(0.65) and scraped["sign_test_p"] < 0.01
    assert scraped["ci95"][0] > 0.4
    assert list(values["network_minus"]["stones"]) == ["oracle", "nominal"]
    without = figures([r for r in results if r.selector == "nominal"])
    assert without["network_minus"] == {} and "minus_oracle" not in without["summary"]["stairs"]["nominal"]
