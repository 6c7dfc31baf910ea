"""`footsel walk` and `footsel compare --walk`: short walks as users order them, and what is wrong said in one line."""

import json

import numpy as np
import pytest

from footsel.cli import walk
from footsel.errors import InputError
from footsel.selectors import SELECTORS
from footsel.walking.courses import WALK_COURSES
from footsel.walking.maps import MAPS


def test_the_names_in_the_help_are_those_that_exist(footsel):
    assert tuple(WALK_COURSES) == walk.TERRAINS
    assert MAPS == walk.MAPS
    text = footsel("walk", "--help").out
    for name in (*WALK_COURSES, *MAPS, *SELECTORS):
        assert name in text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), ("--terrain", "required")),
        (("--terrain", "lava"), ("unknown terrain 'lava'", "flat, slopes, stairs12", "stones_hard", "map's file")),
        (("--terrain", "lava.npz"), ("lava.npz", "no such file")),
        (("--terrain", "flat", "--selector", "guess"), ("unknown selector 'guess'", "cnn+verify")),
        (("--terrain", "flat", "--map", "radar"), ("--map", "radar", "exact", "noisy", "camera")),
        (("--terrain", "flat", "--robot", "dog"), ("unknown robot 'dog'", "anymal_b")),
        (("--terrain", "flat", "--model", "nowhere"), ("no model 'nowhere'",)),
        (("--terrain", "flat", "--seed", "-1"), ("--seed", "-1")),
        (("--terrain", "flat", "--video", "film.avi"), ("--video", "film.avi", ".mp4")),
        (("--terrain", "flat", "--picture", "nowhere/p.png"), ("nowhere", "no folder")),
    ],
)
def test_wrong_use_of_walk(footsel, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert footsel("walk", *arguments).complains(*words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--walk", "lava"), ("unknown terrain 'lava'", "stones_hard")),
        (("--walk", "flat", "lava.npz"), ("lava.npz", "no such file")),
        (("--walk", "flat", "--selectors", "guess"), ("unknown selector 'guess'",)),
        (("--walk", "flat", "--seeds", "0"), ("--seeds", "0")),
        (("--walk", "flat", "--map", "radar"), ("--map", "radar")),
        (("--walk", "flat", "--poses", "3"), ("--poses and --walk exclude each other",)),
        (("map.npz", "--walk", "flat"), ("MAPS and --walk exclude each other",)),
        (("--seeds", "3"), ("--seeds is about walks", "--walk")),
        (("--map", "exact"), ("--map is about walks", "--walk")),
        (("--no-limb-watch",), ("--no-limb-watch is about walks", "--walk")),
        (("--walk", "flat", "--engine", "dask"), ("--scheduler",)),
    ],
)
def test_wrong_use_of_compare_walk(footsel, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert footsel("compare", *arguments, "--out", "demo").complains(*words)
    assert list(tmp_path.iterdir()) == []


def test_a_map_that_nothing_crosses(footsel, tmp_path):
    np.savez(tmp_path / "dot.npz", elevation=np.zeros((4, 4)), resolution=0.02)
    assert footsel("walk", "--terrain", tmp_path / "dot.npz").complains("no line across the map")


def test_a_folder_of_something_else_is_refused(footsel, tmp_path):
    (tmp_path / "letter").touch()
    outcome = footsel("compare", "--walk", "flat", "--seeds", "1", "--selectors", "nominal", "--out", tmp_path)
    assert outcome.complains("is not empty and holds no comparison of walks")
    assert [path.name for path in tmp_path.iterdir()] == ["letter"]


@pytest.fixture
def short_map(tmp_path):
    """Barely a crossing of level ground: with its aprons, a way of some 1.7 m."""
    np.savez(tmp_path / "short.npz", elevation=np.zeros((30, 60)), resolution=0.02)
    return tmp_path / "short.npz"


def test_a_walk_with_all_that_comes_of_it(footsel, tmp_path, short_map):
    video, picture = tmp_path / "w.mp4", tmp_path / "p.png"
    files = ("--video", video, "--picture", picture)
    outcome = footsel("walk", "--terrain", short_map, "--selector", "terrain_only", "--seed", "2", *files)
    assert outcome.code == 0, outcome.err
    result = json.loads(outcome.out)
    assert result["terrain"] == str(short_map) and result["seed"] == 2 and result["map"] == "exact"
    assert result["success"] and result["reason"] == "" and result["distance_m"] > 1.5
    assert result["steps"] > 10 and result["slip_max_mm"] < 50 and result["realtime_factor"] > 0
    assert "reached the goal" in outcome.err
    assert 10_000 < video.stat().st_size < 2_000_000 and picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("command", [("walk", "--terrain"), ("compare", "--jobs", "1", "--seeds", "1", "--walk")])
@pytest.mark.parametrize("option", [(), ("--no-limb-watch",)])
def test_limbs_are_watched_unless_told_otherwise(footsel, tmp_path, monkeypatch, short_map, command, option):
    """Down to where limbs are held against the map."""
    told = []

    def limbs(_robot, watched):
        told.append(watched)
        raise InputError("that is all we want to know", "stop here")

    monkeypatch.setattr("footsel.walking.gait.poses.LimbClearance", limbs)
    out = ("--selectors", "nominal", "--out", tmp_path / "out") if command[0] == "compare" else ()
    assert footsel(*command, short_map, *out, *option).code == 2
    assert told == [not option]


def test_a_comparison_of_walks(footsel, tmp_path, short_map):
    arguments = ("--walk", short_map, "--selectors", "nominal", "terrain_only", "--seeds", "1", "--jobs", "1")
    outcome = footsel("compare", *arguments, "--out", tmp_path / "out")
    assert outcome.code == 0, outcome.err
    written = json.loads((tmp_path / "out" / "walks.json").read_text())
    assert [run["selector"] for run in written["runs"]] == ["nominal", "terrain_only"]
    parts = written["summary"][str(short_map)]
    assert all(part["n"] == 1 and part["success_rate"] == 1 and len(part["ci95"]) == 2 for part in parts.values())
    before = (tmp_path / "out" / "walks.json").read_bytes()
    assert "report.html" in outcome.out and (tmp_path / "out" / "report.html").stat().st_size > 10_000

    # Again: nothing is walked, and the same bytes are written.
    again = footsel("compare", *arguments, "--out", tmp_path / "out")
    assert again.code == 0 and "has 2 of 2 walks" in again.err
    assert (tmp_path / "out" / "walks.json").read_bytes() == before
