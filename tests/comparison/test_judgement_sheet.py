"""The sheet of `footsel evaluate`: what is drawn is what was found."""

import numpy as np
import pytest
from PIL import Image

from footsel.comparison import panels
from footsel.comparison.judgement_sheet import (
    draw_confusion,
    draw_families,
    draw_judgement_sheet,
    draw_reliability,
    draw_thresholds,
    judgement_sheet,
    log_odds,
)

BINS = [
    {"from": 0.0, "to": 0.2, "count": 50, "probability": 0.1, "frequency": 0.2},
    {"from": 0.2, "to": 0.4, "count": 3, "probability": 0.3, "frequency": 1.0},
    {"from": 0.4, "to": 0.6, "count": 40, "probability": 0.5, "frequency": 0.45},
]
CURVE = [
    {"feasible_below": t, "missed_rate": m, "infeasible_rate": i, "regret_mean": r}
    for t, m, i, r in ((0.9, 0.0, 0.06, 4.0), (0.5, 0.004, 0.02, 4.1), (0.01, 0.03, 0.001, 6.0), (0.001, 1, None, None))
]  # fmt: skip
PICKS = {
    "picks": 97,
    "missed_rate": 0.03,
    "infeasible_picks": 2,
    "infeasible_rate": 0.02,
    "infeasible_by_reason": {"UNKNOWN": 0, "KINEMATIC_RANGE": 0, "SELF_COLLISION": 0, "TERRAIN_COLLISION": 2},
    "regret_mean": 5.5,
}
CELLS = {
    "recall_by_reason": {"FEASIBLE": 0.9, "KINEMATIC_RANGE": 0.99, "SELF_COLLISION": None, "TERRAIN_COLLISION": 0.8},
    "cells_by_reason": {"FEASIBLE": 60, "KINEMATIC_RANGE": 30, "SELF_COLLISION": 0, "TERRAIN_COLLISION": 10},
}
FIGURES = {
    "maps": 100,
    "cells": CELLS,
    "picks": PICKS,
    "calibration": {name: {"ece": 0.0125, "bins": BINS} for name in ("infeasible", "likeliest")}
    | {"picks": {"ece": None, "bins": []}},
}


@pytest.fixture
def axes():
    return panels.new_figure(4, 4).subplots()


def result(degradation=None):
    worse = {**FIGURES, "picks": {**PICKS, "infeasible_rate": None, "missed_rate": 0.4, "regret_mean": None}}
    network = {
        "feasible_below": 0.5,
        "all": FIGURES,
        "families": {"flat": FIGURES, "stones": worse},
        "thresholds": CURVE,
    }
    return {"degradation": degradation, "networks": {"front": network, "hind": network}}


def test_frequencies_stand_over_their_probabilities(axes):
    draw_reliability(axes, FIGURES["calibration"])
    _, cells, _, picks = axes.get_lines()
    # The bin of three events is left out.
    np.testing.assert_allclose(cells.get_xdata(), log_odds([0.1, 0.5]))
    np.testing.assert_allclose(cells.get_ydata(), log_odds([0.2, 0.45]))
    assert len(picks.get_xdata()) == 0 and cells.get_label().endswith("ECE 1.25%")


def test_the_curve_and_the_ring_around_the_threshold_in_use(axes):
    draw_thresholds(axes, CURVE, 0.5)
    line, ring = axes.get_lines()[0], axes.get_lines()[-1]
    np.testing.assert_allclose(line.get_xydata()[:3], [[0, 6], [0.4, 2], [3, 0.1]])
    np.testing.assert_allclose(ring.get_xydata(), [[0.4, 2]])
    assert "0.5" in axes.get_title()


def test_every_reason_is_shown_with_what_it_is_called(axes):
    draw_confusion(axes, FIGURES)
    shown = [text.get_text() for text in axes.texts]
    assert shown == ["90.00%", "10.00%", "1.00%", "99.00%", "-", "-", "20.00%", "80.00%"]
    rows = [label.get_text() for label in axes.get_yticklabels()]
    assert rows[0] == "feasible\n60.0% of cells\n95 picks" and rows[3].endswith("\n2 picks")


def test_the_worst_family_stands_at_the_top(axes):
    draw_families(axes, result()["networks"]["front"]["families"])
    assert [label.get_text() for label in axes.get_yticklabels()] == ["flat (5.5)", "stones (-)"]
    assert sorted(round(bar.get_width(), 6) for bar in axes.patches) == [0, 2, 3, 40]


def test_the_sheet_says_what_was_done_to_the_input(tmp_path):
    draw_judgement_sheet(tmp_path / "sheet.png", result())
    with Image.open(tmp_path / "sheet.png") as image:
        assert image.width > 1800 and image.height > 900
    worse = judgement_sheet(result({"noise": "d435", "holes": 0.2, "seed": 0}))
    assert "noise d435, 20% holes" in worse.get_supxlabel() and "200 maps" in worse.get_supxlabel()
