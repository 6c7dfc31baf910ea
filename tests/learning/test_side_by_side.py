"""Two trainings at once: the same models as one after the other, and one line if something goes wrong in either."""

import os
import time
from dataclasses import replace
from functools import partial

import pytest
import torch
from safetensors import safe_open

from footsel.dataset.store import MANIFEST, pack_shard, pair_entry, record_shard, shard_path, write_shard
from footsel.errors import InputError
from footsel.files import write_json
from footsel.learning.recipe import Recipe
from footsel.learning.side_by_side import in_turn, side_by_side
from footsel.learning.train import train

MODULE = '''
import os, signal, time
from pathlib import Path
from footsel.errors import UnknownNameError

def meet(folder, pair, bar_line=None):
    """Ends once both are there: they run at the same time."""
    (Path(folder) / pair).write_text(str(os.getpid()))
    while len(list(Path(folder).iterdir())) < 2:
        time.sleep(0.01)
    return {"pid": os.getpid(), "line": bar_line}

def fail(folder, pair, bar_line=None):
    meet(folder, pair)
    if pair == "hind":
        raise UnknownNameError("cake", "apple", ("lemon",))
    time.sleep(600)

def die(folder, pair, bar_line=None):
    os.kill(os.getpid(), signal.SIGKILL)
'''


@pytest.fixture
def trainings(tmp_path, monkeypatch):
    """A module that a new process can import, too."""
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "trainings_of_a_test.py").write_text(MODULE)
    monkeypatch.syspath_prepend(str(tmp_path / "code"))
    import trainings_of_a_test

    return trainings_of_a_test


def ended(pid):
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


def test_they_run_at_the_same_time_each_with_a_line_of_its_own(trainings, tmp_path):
    (tmp_path / "met").mkdir()
    found = dict(side_by_side(partial(trainings.meet, tmp_path / "met"), ("front", "hind")))
    assert {pair: info["line"] for pair, info in found.items()} == {"front": 0, "hind": 1}
    assert len({os.getpid(), *(info["pid"] for info in found.values())}) == 3


def test_an_error_of_one_is_told_and_ends_the_other(trainings, tmp_path):
    (tmp_path / "met").mkdir()
    with pytest.raises(InputError, match="unknown cake 'apple'; choose from: lemon"):
        list(side_by_side(partial(trainings.fail, tmp_path / "met"), ("front", "hind")))
    assert ended(int((tmp_path / "met" / "front").read_text()))


def test_a_training_that_is_killed_is_told(trainings, tmp_path):
    with pytest.raises(InputError, match="training of front ended with code -9; resume it"):
        list(side_by_side(partial(trainings.die, tmp_path), ("front",)))


def test_the_models_are_those_of_one_after_the_other(make_samples, tmp_path):
    entries = {}
    for seed, pair in enumerate(("front", "hind")):
        for number in range(2):
            write_shard(shard_path(tmp_path / "data", pair, number), pack_shard(make_samples(8, 2 * seed + number)))
        entries[pair] = pair_entry([record_shard(tmp_path / "data", pair, number) for number in range(2)])
    write_json(tmp_path / "data" / MANIFEST, {"config": {"robot": "anymal_b"}, "pairs": entries})
    recipe = replace(Recipe.load("footsel"), batch_size=4, noise=0.5)
    weights = {}
    for name, run in (("turns", in_turn), ("both", side_by_side)):
        out = tmp_path / name
        infos = dict(run(partial(train, tmp_path / "data", out, recipe=recipe, epochs=1), ("front", "hind")))
        assert infos["front"]["pair"] == "front" and infos["hind"]["epochs_done"] == 1
        for pair in infos:
            with safe_open(out / pair / "model.safetensors", framework="pt") as file:
                weights[name, pair] = {key: file.get_tensor(key) for key in file.keys()}  # noqa: SIM118
    for pair in ("front", "hind"):
        one, other = weights["turns", pair], weights["both", pair]
        assert all(torch.equal(tensor, other[key]) for key, tensor in one.items())
