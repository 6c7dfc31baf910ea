"""`footsel compare` as a user types it: both files or none."""

import json

import numpy as np
import pytest

from footsel.cli.main import main


@pytest.fixture
def map_file(tmp_path, maps):
    path = tmp_path / "maps" / "stairs.npz"
    path.parent.mkdir()
    maps[0].elevation_map.save(path)
    return path


def run(capsys, *arguments):
    code = main(["compare", *(str(argument) for argument in arguments)])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def test_both_files_are_written(capsys, tmp_path, map_file, model):
    out = tmp_path / "deep" / "demo"
    arguments = (map_file, "--selectors", "oracle", "cnn", "nominal", "--poses", 3, "--jobs", 1, "--model", model)
    code, text, _ = run(capsys, *arguments, "--out", out)
    assert code == 0
    assert str(out / "report.html") in text
    assert sorted(path.name for path in out.iterdir()) == ["compare.json", "report.html"]
    assert [path.name for path in out.parent.iterdir()] == ["demo"]
    figures = json.loads((out / "compare.json").read_text())
    assert figures["maps"] == [str(map_file)]
    assert figures["poses"] == 3
    assert set(figures["selectors"]) == {"oracle", "cnn", "nominal"}
    assert figures["run"]["command"].startswith("footsel compare ")
    assert "--out demo" in figures["run"]["command"] and str(out) not in figures["run"]["command"]
    assert "<title>" in (out / "report.html").read_text()

    # A second run replaces both files and leaves other files alone.
    (out / "notes.txt").write_text("mine")
    code, _, _ = run(capsys, map_file, "--selectors", "nominal", "--poses", 2, "--jobs", 1, "--out", out)
    assert code == 0
    assert sorted(path.name for path in out.iterdir()) == ["compare.json", "notes.txt", "report.html"]
    assert set(json.loads((out / "compare.json").read_text())["selectors"]) == {"nominal"}


def bad_maps(tmp_path):
    np.savez(tmp_path / "nan.npz", elevation=np.full((20, 20), np.nan), resolution=0.02)
    np.savez(tmp_path / "keys.npz", heights=np.zeros((20, 20)))
    return {"missing.npz": "no such file", "nan.npz": "known cell", "keys.npz": "elevation"}


@pytest.mark.parametrize("name", ["missing.npz", "nan.npz", "keys.npz"])
def test_bad_maps_leave_nothing_behind(capsys, tmp_path, map_file, name):
    words = bad_maps(tmp_path)[name]
    before = sorted(tmp_path.rglob("*"))
    arguments = (map_file, tmp_path / name, "--selectors", "nominal", "--poses", 2, "--jobs", 1)
    code, text, errors = run(capsys, *arguments, "--out", tmp_path / "demo")
    assert code == 2
    assert text == ""
    assert errors.count("\n") == 1
    assert name in errors
    assert words in errors
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--selectors", "guess"), "unknown selector 'guess'"),
        (("--selectors", "cnn", "--model", "nowhere"), "no model 'nowhere'"),
        (("--poses", "0"), "0"),
        (("--robot", "dog"), "unknown robot 'dog'"),
        (("--seed", "-1"), "-1"),
    ],
)
def test_wrong_use_is_said_in_one_line(capsys, tmp_path, map_file, arguments, words):
    code, _, errors = run(capsys, map_file, *arguments, "--jobs", 1, "--out", tmp_path / "demo")
    assert code == 2
    assert errors.count("\n") == 1
    assert words in errors
    assert not (tmp_path / "demo").exists()


def test_an_output_below_a_file_is_refused_before_the_work(capsys, map_file):
    code, _, errors = run(capsys, map_file, "--selectors", "nominal", "--out", map_file / "demo")
    assert code == 2
    assert "no folder to write to" in errors


def test_a_map_given_twice_is_refused(capsys, tmp_path, map_file):
    code, _, errors = run(capsys, map_file, map_file, "--selectors", "nominal", "--out", tmp_path / "demo")
    assert code == 2
    assert "given twice" in errors
