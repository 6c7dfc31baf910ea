"""docs/judge_int8.py: enough picks of both variants, judged at the same poses."""

import json
import sys

import pytest

from footsel.comparison.maps import built_in_courses
from footsel.robot import load_robot


@pytest.fixture
def model(tmp_path, handmade):
    """float32 and int8 differ as much as two random filters do."""
    layout = load_robot("anymal_b").layout
    files = {
        f"{pair}{end}": handmade.random_model(handmade.contract(layout, pair, feasible_below=0.9), seed)
        for pair in ("front", "hind")
        for seed, end in enumerate((".onnx", ".int8.onnx"))
    }
    return handmade.write_folder(tmp_path / "model", files)


def test_both_variants_are_judged_until_there_are_enough_picks(script, model, tmp_path, monkeypatch, capsys):
    module = script("judge_int8")
    monkeypatch.setattr(module, "RESULTS", tmp_path)
    monkeypatch.setattr(module, "built_in_courses", lambda seed: built_in_courses(seed, ("steps", "stones")))
    monkeypatch.setattr(sys, "argv", ["judge_int8.py", str(model), "--picks", "40"])
    assert module.main() == 1
    assert "BEYOND THE LIMITS" in capsys.readouterr().out
    courses = json.loads((tmp_path / "int8.json").read_text())["grounds"]["courses"]
    cnn, int8 = (courses["selectors"][name] for name in ("cnn", "cnn:int8"))
    assert min(cnn["picks"], int8["picks"]) >= 40
    assert courses["questions"] == courses["poses"] * 2 * 4
    assert courses["worse_by"]["infeasible_rate"] == int8["infeasible_rate"] - cnn["infeasible_rate"]
    assert courses["worse_by"]["regret_mean"] == int8["regret_mean"] - cnn["regret_mean"]
    tables = script("update_tables")
    monkeypatch.setattr(tables, "RESULTS", tmp_path)
    text = tables.eight_bits()
    assert f"| courses, `cnn:int8` | {int8['picks']} |" in text and "beyond the limits of 0.5 and 0.1" in text


def test_a_model_without_eight_bits_is_refused(script, model_folder, monkeypatch, capsys):
    module = script("judge_int8")
    monkeypatch.setattr(sys, "argv", ["judge_int8.py", str(model_folder)])
    assert module.main() == 2
    assert "variants of this model: float32" in capsys.readouterr().err
