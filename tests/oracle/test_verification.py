"""`make verify`: figures of what was compared, a report that anyone can follow up, runs that go on after a kill."""

import json
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.footholds import Reason
from footsel.footholds.pose import BasePose, tilt_rotation
from footsel.oracle import Oracle, labeler
from footsel.oracle.verification import __main__ as command
from footsel.oracle.verification import parts as parts_module
from footsel.oracle.verification.comparison import Comparison, compare_source, evenly_by_size
from footsel.oracle.verification.places import draw_cells, open_source
from footsel.terrain import LocalMap
from footsel.terrain.courses import FAMILIES, make_course

SMALL = ("--cells", "8", "--cells-per-place", "4", "--margins", "0", "--jobs", "1")


@pytest.fixture
def two_families(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "FAMILIES", {name: FAMILIES[name] for name in ("flat", "pillars")})


@pytest.mark.usefixtures("two_families")
def test_it_writes_its_figures(tmp_path: Path) -> None:
    make_course("steps", 4, size=3.0).save(tmp_path / "mine.npz")
    out = tmp_path / "verify.json"
    assert command.main([str(tmp_path / "mine.npz"), *SMALL, "--margins", "1", "--out", str(out)]) == 0
    figures = json.loads(out.read_text())
    assert figures["passed"] and figures["differing_reasons"] == 0 and figures["differing"] == []
    assert list(figures["by_source"]) == ["flat", "pillars", "mine.npz"]
    assert figures["legs"] == ["LF", "LH", "RF", "RH"]
    assert figures["cells"] == sum(figures["cells_by_reason"].values()) >= figures["known_cells"] == 3 * 4 * 8
    for row in figures["by_source"].values():
        assert sum(row["shares"].values()) == pytest.approx(1.0)
    assert figures["margins"] == sum(row["margins"] for row in figures["by_source"].values()) > 0
    assert figures["margins"] == sum(size["margins"] for size in figures["margins_by_size"])
    low, high = figures["base_height_m"]
    assert 0.36 <= low < high <= 0.60 + 5e-3 and 0 < figures["tilt_deg"] <= 15


def test_a_differing_cell_is_told_so_that_anyone_can_look_at_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command, "FAMILIES", {"pillars": FAMILIES["pillars"]})
    monkeypatch.setattr(labeler, "tilt_rotation", lambda roll, pitch: tilt_rotation(-roll, pitch))
    out = tmp_path / "verify.json"
    assert command.main(["--cells", "60", "--margins", "0", "--jobs", "1", "--out", str(out)]) == 1
    figures = json.loads(out.read_text())
    assert not figures["passed"] and figures["differing_reasons"] > 0
    line = figures["differing"][0]
    assert line in capsys.readouterr().out
    place, _, verdicts = line.partition(": ")
    words = shlex.split(place)
    assert words[:3] == ["course", "pillars", "seed"]
    leg, pose = words[words.index("--leg") + 1], words[words.index("--pose") + 1 :][:6]
    cell = tuple(int(word) for word in words[words.index("--cell") + 1 :])
    # The same place again, with the fault: the same verdict.
    oracle, base = Oracle.load(), BasePose.of([float(word) for word in pose])
    local_map = oracle.robot.layout.local_map(make_course("pillars", int(words[3])), base, leg)
    reason = Reason(int(oracle.label(local_map, leg, base.roll, base.pitch).reason[cell]))
    assert verdicts.startswith(reason.name)
    assert ", the reference says " in verdicts


def test_a_wrong_terrain_cost_or_margin_fails() -> None:
    fine = Comparison(reasons=[1, 0, 0, 0, 0], margins=[[0.1, 0.1005]])
    for part, passed in (
        (fine, True),
        (Comparison(**{**fine.to_dict(), "terrain_cost_error": 2e-6}), False),
        (Comparison(**{**fine.to_dict(), "terrain_cost_error": np.inf}), False),
        (Comparison(**{**fine.to_dict(), "margins": [[0.1, 0.104]]}), False),
        (Comparison(**{**fine.to_dict(), "differing": ["cell"]}), False),
    ):
        assert command.summary({("flat", "LF"): part}, {})["passed"] is passed


@pytest.mark.usefixtures("two_families")
def test_finished_parts_are_used_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "verify.json"
    assert command.main([*SMALL, "--out", str(out)]) == 0
    first = out.read_bytes()
    folder = tmp_path / "verify.json.parts"
    assert len(list(folder.iterdir())) == 8
    (folder / "pillars-RH.json").unlink()
    (folder / "flat-LF.json").write_text('{"key": {}, "part"')
    compared: list[tuple[str, str]] = []

    def counting(source: str, leg: str, **settings: int) -> Comparison:
        compared.append((source, leg))
        return compare_source(source, leg, **settings)

    monkeypatch.setattr(command, "compare_source", counting)
    assert command.main([*SMALL, "--out", str(out)]) == 0
    assert compared == [("flat", "LF"), ("pillars", "RH")]
    assert out.read_bytes() == first


def test_parts_of_other_settings_code_or_maps_are_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "map.npz"
    make_course("steps", 4, size=2.0).save(source)
    store = parts_module.Parts(tmp_path / "parts", {"cells": 8})
    store.write(str(source), "LF", {"places": 1})
    assert store.read(str(source), "LF") == {"places": 1}
    assert store.read(str(source), "RF") is None
    assert parts_module.Parts(tmp_path / "parts", {"cells": 9}).read(str(source), "LF") is None
    monkeypatch.setattr(parts_module, "code_fingerprint", lambda: "other")
    assert parts_module.Parts(tmp_path / "parts", {"cells": 8}).read(str(source), "LF") is None
    make_course("steps", 5, size=2.0).save(source)
    assert store.read(str(source), "LF") is None


def test_a_killed_run_goes_on_where_it_stopped(tmp_path: Path) -> None:
    out = tmp_path / "verify.json"
    arguments = [sys.executable, "-m", "footsel.oracle.verification", *SMALL, "--out", str(out)]
    with subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
        deadline = time.monotonic() + 60
        while len(list((tmp_path / "verify.json.parts").glob("*.json"))) < 3:
            assert run.poll() is None and time.monotonic() < deadline
            time.sleep(0.02)
        run.send_signal(signal.SIGKILL)
    assert not out.exists()
    again = subprocess.run(arguments, capture_output=True, text=True, check=True)
    assert "parts were compared before" in again.stderr
    assert json.loads(out.read_text())["known_cells"] == len(FAMILIES) * 4 * 8


def test_margins_are_chosen_evenly_over_their_size() -> None:
    rng = np.random.default_rng(0)
    margins = [*rng.uniform(0.0, 0.02, 500), *rng.uniform(0.02, 0.04, 20), 0.15]
    chosen = evenly_by_size(margins, 13, rng)
    assert len(set(chosen)) == 13
    sizes = np.floor(np.array(margins)[chosen] / 0.02).astype(int).tolist()
    assert (sizes.count(0), sizes.count(1), sizes.count(7)) == (6, 6, 1)
    assert len(evenly_by_size(margins[:3], 13, rng)) == 3
    assert evenly_by_size([], 5, rng) == []


def test_cells_are_known_as_far_as_there_are_enough() -> None:
    rng = np.random.default_rng(0)
    heights = np.full((40, 40), np.nan)
    heights[:10] = 0.0
    half_known = LocalMap(heights, 0.02, np.zeros(3), 0.0)
    for most, known, unknown in ((200, 190, 10), (1600, 400, 80)):
        cells = draw_cells(half_known, most, rng)
        found = half_known.known[tuple(cells.T)]
        assert (int(found.sum()), int((~found).sum())) == (known, unknown)
        assert len({tuple(cell) for cell in cells.tolist()}) == len(cells)


def test_sources_are_families_or_files(tmp_path: Path) -> None:
    course = make_course("stairs", 7)
    course.save(tmp_path / "stairs.npz")
    for opened in (open_source("stairs", 7), open_source(str(tmp_path / "stairs.npz"), None)):
        assert isinstance(opened, ElevationMap)
        np.testing.assert_array_equal(opened.elevation, course.elevation)
