"""The control loop: it ticks as asked, tells its times, and tells what is wrong in one line."""

import json
import sys

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.runtime import FootholdSelector
from footsel.terrain.courses import make_course


@pytest.fixture
def module(deployed):
    return deployed("control_loop")


def run(module, monkeypatch, capsys, *arguments):
    monkeypatch.setattr(sys, "argv", ["control_loop.py", *map(str, arguments)])
    return module.main(), capsys.readouterr()


def test_it_ticks_and_tells(module, monkeypatch, capsys, tmp_path):
    make_course("stairs", 2, size=4.0).save(tmp_path / "map.npz")
    code, printed = run(module, monkeypatch, capsys, tmp_path / "map.npz", "--rate", 200, "--seconds", 0.2)
    told = json.loads(printed.out)
    assert code == 0 and told["ticks"] == 40 and 0 <= told["late"] <= 40 and told["none"] <= 40
    times = told["time_ms"]
    assert 0 < times["p50"] <= times["p99"] <= times["p999"] <= times["max"]


def test_the_base_stays_on_the_map_and_legs_take_turns(module):
    selector = FootholdSelector.load("anymal_b")
    walk = module.Walk(make_course("flat", 0, size=4.0), selector.layout)
    x = [walk.pose(now)[0] for now in np.linspace(0, 100, 400)]
    assert -1 <= min(x) < -0.9 and 0.9 < max(x) <= 1 and np.abs(np.diff(x)).max() < 0.03
    assert {walk.swing_leg(now) for now in np.arange(0, 2, 0.1)} == {"LF", "RF", "LH", "RH"}


def test_a_map_that_is_unknown_has_no_footholds(module):
    unknown = ElevationMap(np.full((100, 100), np.nan), 0.02)
    told = module.run(FootholdSelector.load("anymal_b"), unknown, 500, 0.02)
    assert told["none"] == told["ticks"] == 10


def test_bad_input_gets_one_line(module, monkeypatch, capsys, tmp_path):
    code, printed = run(module, monkeypatch, capsys, tmp_path / "absent.npz")
    assert code == 2 and printed.err.count("\n") == 1 and "absent.npz" in printed.err
    with pytest.raises(SystemExit, match="2"):
        run(module, monkeypatch, capsys, tmp_path / "absent.npz", "--rate", -1)
