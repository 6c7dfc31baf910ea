"""Several processes train what one does: layers, shares, and two real processes under torchrun, killed and resumed."""

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file
from torch import nn

from footsel.cli.main import main
from footsel.dataset.store import MANIFEST, pack_shard, pair_entry, record_shard, shard_path, write_shard
from footsel.files import write_json
from footsel.learning.checkpoint import load_network
from footsel.learning.ranks import ALONE, Ranks, ranks_of_torchrun
from footsel.learning.recipe import Recipe
from footsel.learning.shared_layers import SharedBatchNorm2d, SharedDropout2d

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("maps", [0, 1, 2, 7, 64])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_shares_are_the_parts_of_a_batch(maps, count):
    parts = [np.arange(maps)[Ranks(number, count).share(maps)] for number in range(count)]
    assert np.concatenate(parts).tolist() == list(range(maps))
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


def test_without_torchrun_there_is_one_process():
    with ranks_of_torchrun() as ranks:
        assert ranks is ALONE


def test_shared_batch_normalisation_of_one_process_is_torchs():
    generator = torch.Generator().manual_seed(0)
    norm = nn.BatchNorm2d(6, eps=1e-3)
    with torch.no_grad():
        norm.weight.uniform_(0.5, 2, generator=generator)
        norm.bias.uniform_(-1, 1, generator=generator)
    shared = SharedBatchNorm2d(norm, ALONE)
    # Far from zero, where the difference of mean squares would have no digits left.
    maps = 50 + torch.rand((4, 6, 5, 5), generator=generator)
    factor = torch.rand(maps.shape, generator=generator)
    found = []
    for layer in (norm, shared):
        values = maps.clone().requires_grad_()
        out = layer(values)
        (out * factor).sum().backward()
        found.append([out.detach(), values.grad, layer.weight.grad, layer.bias.grad, *layer.buffers()])
        found[-1].append(layer.eval()(maps))
    for ours, theirs in zip(*found, strict=True):
        torch.testing.assert_close(ours, theirs, rtol=1e-4, atol=1e-4)


def test_shared_dropout_of_one_process_is_torchs():
    maps = torch.rand((5, 16, 3, 3))
    dropout = nn.Dropout2d(0.3)
    shared = SharedDropout2d(dropout, ALONE)
    found = []
    for layer in (dropout, shared):
        torch.manual_seed(3)
        found.append(torch.cat([layer(maps), layer(maps)]))
    assert torch.equal(*found) and (found[0] == 0).any()
    assert torch.equal(shared.eval()(maps), maps)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory, make_samples):
    """16 maps to learn from: batches of 5, 5, 5 and 1, which leaves one of two processes without any."""
    folder = tmp_path_factory.mktemp("ranks") / "data"
    for number in range(3):
        write_shard(shard_path(folder, "front", number), pack_shard(make_samples(8, number)))
    entry = pair_entry([record_shard(folder, "front", number) for number in range(3)])
    write_json(folder / MANIFEST, {"config": {"robot": "anymal_b"}, "pairs": {"front": entry}})
    return folder


@pytest.fixture
def recipes(tmp_path):
    """Files of small recipes with everything that looks at a whole batch, in float32 to compare more digits."""
    changes = {"batch_size": 5, "epochs": 3, "precision": "float32"}
    small = {"cells": [8, 8], "widths": [12, 16], "blocks": [1, 1, 1], "noise": 1.0, "learning_rate": 3e-4}
    files = {}
    for name, values in {"footsel": small, "paper": {}}.items():
        recipe = {**Recipe.load(name).to_dict(), **changes, **values}
        recipe.pop("name")
        files[name] = tmp_path / f"{name}.toml"
        # Of such values JSON is TOML.
        files[name].write_text(
            "\n".join(f"{key} = {json.dumps(value)}" for key, value in recipe.items() if value is not None)
        )
    return files


def command(dataset, out, recipe, *options):
    return ["train", str(dataset), str(out), "--legs", "front", "--recipe", str(recipe), *options]


def run(*arguments):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True, check=False, timeout=300
    )


def torchrun(arguments, program=("-m", "footsel.cli.main")):
    """Two processes."""
    launcher = ["-m", "torch.distributed.run", "--standalone", "--nproc-per-node", "2"]
    return run(*launcher, *program, *map(str, arguments))


def curve(out):
    with (out / "front" / "curves.csv").open() as file:
        return [{key: float(value) for key, value in row.items() if key != "seconds"} for row in csv.DictReader(file)]


GRADIENTS = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np, torch
from conftest import stepped_maps
from safetensors.torch import save_file
from footsel.learning.learner import Learner
from footsel.learning.ranks import ranks_of_torchrun
from footsel.learning.recipe import Recipe
from footsel.learning.shared_layers import share_layers
from footsel.learning.skeleton import LegSkeleton
from footsel.robot import load_robot

layout, skeleton = load_robot("anymal_b").layout, LegSkeleton.of(load_robot("anymal_b"), "LF")
weights = np.linspace(1, 3, 14, dtype=np.float32)
with ranks_of_torchrun() as ranks:
    found = {{}}
    for recipe in sys.argv[2:]:
        for maps in (7, 1):
            learner = Learner(Recipe.load(recipe), layout, weights, 0, ranks, skeleton)
            if ranks.count == 1:
                share_layers(learner.net, ranks)
            loss = learner.update(stepped_maps(maps, maps), 1e-12, 0)
            values = {{"loss": torch.tensor([loss]), "random state": torch.get_rng_state()}}
            values |= dict(learner.net.named_buffers())
            values |= {{name: parameter.grad for name, parameter in learner.net.named_parameters()}}
            found |= {{f"{{recipe}} {{maps}} {{name}}": value.clone().contiguous() for name, value in values.items()}}
    save_file(found, f"{{sys.argv[1]}}.{{ranks.number}}")
"""


def test_gradients_are_those_of_the_whole_batch(recipes, tmp_path):
    """Each process has them: of weighted losses, batch statistics and dropped channels, with maps or without.

    The one process has the shared layers, too. They round differently than torch's, and the gradients of an untrained
    ERFNet change by percents if its weights change in their seventh digit.
    """
    program = tmp_path / "gradients.py"
    program.write_text(GRADIENTS.format(tests=str(Path(__file__).parent)))
    files = [str(file) for file in recipes.values()]
    done = run(str(program), str(tmp_path / "one"), *files)
    assert done.returncode == 0, done.stderr
    done = torchrun([tmp_path / "two", *files], program=(str(program),))
    assert done.returncode == 0, done.stderr
    one, *two = (load_file(tmp_path / name) for name in ("one.0", "two.0", "two.1"))
    assert one.keys() == two[0].keys() == two[1].keys() and len(one) > 300
    for name, expected in one.items():
        assert torch.equal(two[0][name], two[1][name]), name
        # A bias before a batch normalisation has no gradient but rounding.
        torch.testing.assert_close(two[0][name], expected, rtol=1e-4, atol=2e-5, msg=name)


def test_two_processes_give_the_curve_of_one(dataset, recipes, tmp_path):
    assert main(command(dataset, tmp_path / "one", recipes["footsel"])) == 0
    done = torchrun(command(dataset, tmp_path / "two", recipes["footsel"]))
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
    assert done.stdout.count("3 epochs") == done.stdout.count("next: footsel export") == 1
    one, two = curve(tmp_path / "one"), curve(tmp_path / "two")
    assert len(one) == len(two) == 3
    for ours, theirs in zip(one, two, strict=True):
        for key in ("lr", "train_loss", "val_loss"):
            assert ours[key] == pytest.approx(theirs[key], rel=2e-4), key
        assert ours["accuracy"] == pytest.approx(theirs["accuracy"], abs=2e-3)
    files = [{path.name for path in (tmp_path / out / "front").iterdir()} for out in ("one", "two")]
    assert files[0] == files[1]
    assert load_network(tmp_path / "two" / "front")[1]["epochs_done"] == 3


#: The first process dies right after a checkpoint within the second epoch.
KILLED = """
import os, signal, sys
from functools import partial
from footsel.cli.main import main
from footsel.learning import train

def save_then_die(folder, learner, progress, save=train.save_checkpoint):
    save(folder, learner, progress)
    if (progress.epoch, progress.batch) == (1, 2):
        os.kill(os.getpid(), signal.SIGKILL)

train.save_checkpoint = save_then_die
train.fit = partial(train.fit, checkpoint_seconds=0)
sys.exit(main(sys.argv[1:]))
"""


def test_killed_it_goes_on_as_if_nothing_had_happened(dataset, recipes, tmp_path):
    """With ERFNet, whose dropped channels depend on the random state."""
    program = tmp_path / "killed.py"
    program.write_text(KILLED)
    whole, broken = (command(dataset, tmp_path / name, recipes["paper"]) for name in ("whole", "broken"))
    done = torchrun(whole)
    assert done.returncode == 0, done.stderr
    done = torchrun(broken, program=(str(program),))
    assert done.returncode != 0 and len(curve(tmp_path / "broken")) == 1

    refused = torchrun(broken)
    assert refused.returncode != 0
    assert "already holds a training; give --resume" in refused.stderr
    assert "footsel/learning/train.py" not in refused.stderr  # No traceback of ours.

    # One process can go on, too; how far rounding leads is said in docs/learning.md.
    shutil.copytree(tmp_path / "broken", tmp_path / "alone")
    assert main([*command(dataset, tmp_path / "alone", recipes["paper"]), "--resume"]) == 0
    alone = [row["train_loss"] for row in curve(tmp_path / "alone")]
    assert alone == pytest.approx([row["train_loss"] for row in curve(tmp_path / "whole")], rel=0.02)

    done = torchrun([*broken, "--resume"])
    assert done.returncode == 0, done.stderr
    assert curve(tmp_path / "whole") == curve(tmp_path / "broken")
    one, other = (load_network(tmp_path / name / "front")[0].state_dict() for name in ("whole", "broken"))
    assert all(torch.equal(tensor, other[name]) for name, tensor in one.items())
