"""The tables of the model card, from figures by hand."""

from footsel.exporting import card_figures
from footsel.learning.threshold import THRESHOLDS


def figures(infeasible=0.02, missed=0.01, **more):
    picks = {"picks": 50, "infeasible_rate": infeasible, "missed": 1, "missed_rate": missed, "regret_mean": 4.25}
    return {"maps": 60, "picks": picks, "cells": {"recall_by_reason": {"SELF_COLLISION": 0.875}}, **more}


def cells(line):
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_all_figures_of_both_pairs_stand_side_by_side():
    lines = [cells(line) for line in card_figures.overall({"front": figures(), "hind": figures(0.25)})]
    assert lines[0] == ["", "front", "hind"]
    assert ["picks that the oracle rejects", "2.00%", "25.00%"] in lines
    assert ["self collision recognised", "87.50%", "87.50%"] in lines
    # What an older network does not know is a dash.
    assert ["calibration error of p(infeasible), cells", "-", "-"] in lines


def test_families_below_all():
    lines = [cells(line) for line in card_figures.by_family(figures(families={"stones": figures(0.1, None)}))]
    assert [line[0] for line in lines] == ["family", "---", "all", "stones"]
    assert lines[3][1:] == ["60", "-", "-", "-", "50", "10.00%", "-", "4.2"]


def test_the_threshold_in_use_is_among_those_shown():
    curve = [{"feasible_below": each, "picks": 9, "infeasible_rate": None} for each in THRESHOLDS]
    for used in (THRESHOLDS[4], THRESHOLDS[7]):
        lines = card_figures.along_thresholds({"thresholds": curve}, used)
        bold = [line for line in lines if "**" in line]
        assert len(bold) == 1 and cells(bold[0])[0] == f"**{used:.3g}**"
        assert 9 < len(lines) < 15
    assert len(card_figures.along_thresholds({}, 0.1)) == 2


def test_confidences_are_counted_in_their_range():
    bins = [
        {"count": 3, "probability": 0.5, "frequency": 0.0},
        {"count": 1, "probability": 0.95, "frequency": 1.0},
        {"count": 3, "probability": 0.91, "frequency": 1 / 3},
        {"count": 2, "probability": 1.0, "frequency": 1.0},
    ]
    lines = card_figures.confidences({"front": {"calibration": {"picks": {"bins": bins}}}, "hind": {}})
    assert cells(lines[2]) == ["0 to 0.9", "3", "50.00%", "0.00%", "0", "-", "-"]
    assert cells(lines[3]) == ["0.9 to 0.97", "4", "92.00%", "50.00%", "0", "-", "-"]
    assert cells(lines[6]) == ["0.999 to 1", "2", "100.00%", "100.00%", "0", "-", "-"]


def test_what_is_much_worse_than_the_rest_is_named():
    families = {"flat": figures(0.0, 0.0), "pillars": figures(0.05, 0.011), "stones": figures(0.2, 0.3)}
    lines = card_figures.weak_spots({"front": figures(families=families), "hind": figures()})
    assert lines == [
        "- front: picks that the oracle rejects are 2.0% of all, but stones 20.0%, pillars 5.0%.",
        "- front: missed footholds are 1.0% of all, but stones 30.0%.",
    ]
