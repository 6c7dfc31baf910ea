"""`footsel walk` and `footsel compare --walk`: what is wrong is said in one line, before anything walks."""

import numpy as np
import pytest

from footsel.cli import walk
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
