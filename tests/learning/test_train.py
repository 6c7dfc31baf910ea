"""Training: it learns, survives being killed, and gives the same curve as if nothing had happened."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors import safe_open

from footsel.errors import InputError, ModelError
from footsel.footholds import Reason
from footsel.learning import train as training
from footsel.learning.batches import BatchEncoder
from footsel.learning.checkpoint import load_network, network_predictor
from footsel.learning.loss import LABEL_CLASS
from footsel.learning.predictions import predict_all
from footsel.learning.recipe import Recipe
from footsel.learning.threshold import threshold_curve
from footsel.learning.train import fit

QUICK = {name: replace(Recipe.load(name), epochs=2, batch_size=8) for name in ("paper", "footsel")}
#: Everything that a recipe can ask for beside.
QUICK["all"] = replace(QUICK["footsel"], ordinal=0.5, reason_weight=0.3, collision_weight=2.0, noise=0.5, holes=0.5)


def curve(folder):
    """Rows of a run's curve; time alone may differ between two runs."""
    with (folder / "curves.csv").open() as file:
        return [{key: value for key, value in row.items() if key != "seconds"} for row in csv.DictReader(file)]


def weights(folder):
    with safe_open(folder / "model.safetensors", framework="pt") as file:
        return {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118


def assert_same_run(one, other):
    assert curve(one) == curve(other)
    ours, theirs = weights(one), weights(other)
    assert ours.keys() == theirs.keys() and all(torch.equal(ours[name], theirs[name]) for name in ours)


@pytest.mark.parametrize("name", QUICK)
def test_loss_falls_and_the_run_says_what_it_is(data, tmp_path, name):
    # A rate high enough for thirty updates on a handful of maps, and none of the paper's decay over 500 epochs.
    recipe = replace(QUICK[name], epochs=10, learning_rate=5e-3, ema_decay=min(QUICK[name].ema_decay, 0.9), decay=1.0)
    info = fit(data, tmp_path / "front", recipe)
    losses = [float(row["train_loss"]) for row in curve(tmp_path / "front")]
    assert len(losses) == 10 and losses[-1] < 0.85 * losses[0]
    assert info["epochs_done"] == 10 and info["recipe"] == recipe.to_dict() and info["dataset_sha256"] == "0" * 64
    judgement = json.loads((tmp_path / "front" / "validation.json").read_text())
    assert judgement["feasible_below"] == info["feasible_below"]
    assert judgement["metrics"]["picks"]["picks"] + judgement["metrics"]["picks"]["none"] == 6
    assert json.loads((tmp_path / "front" / "config.json").read_text())["seed"] == 0
    assert not list((tmp_path / "front").glob("*.tmp*"))

    net, _ = load_network(tmp_path / "front")
    assert not net.training and net.in_channels == len(recipe.planes)
    predictions = predict_all(network_predictor(net, BatchEncoder(recipe.encoding(0.85))), data.validation)
    right = predictions.likeliest == LABEL_CLASS[data.validation.cost]
    known = data.validation.reason != Reason.UNKNOWN
    assert right[known].mean() == pytest.approx(info["validation"]["cells_likeliest"]["accuracy"])


class KilledError(Exception):
    pass


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("checkpoints", [2, 5])  # within the first epoch; right after it and one batch
def test_a_resumed_training_is_the_uninterrupted_one(data, tmp_path, monkeypatch, name, checkpoints):
    fit(data, tmp_path / "whole", QUICK[name], seed=4)

    save, calls = training.save_checkpoint, []

    def save_then_die(*args):
        save(*args)
        calls.append(args)
        if len(calls) == checkpoints:
            raise KilledError

    monkeypatch.setattr(training, "save_checkpoint", save_then_die)
    with pytest.raises(KilledError):
        fit(data, tmp_path / "broken", QUICK[name], seed=4, checkpoint_seconds=0)
    monkeypatch.setattr(training, "save_checkpoint", save)
    torch.manual_seed(99)
    fit(data, tmp_path / "broken", QUICK[name], resume=True, seed=4)
    assert_same_run(tmp_path / "whole", tmp_path / "broken")


CHILD = """
import sys, torch
sys.path.insert(0, {tests!r})
from conftest import stepped_maps
from footsel.footholds import LegLayout
from footsel.learning.recipe import Recipe
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.train import TrainingData, fit
import json
from pathlib import Path
torch.set_num_threads(1)
robot = LegLayout.from_dict(json.loads({layout!r})), LegSkeleton.from_dict(json.loads({skeleton!r}))
maps = stepped_maps(24, 1), stepped_maps(6, 2)
data = TrainingData("front", *maps, "anymal_b", *robot, {{"maps": 30}}, "0" * 64)
fit(data, Path({out!r}), Recipe.from_dict(json.loads({recipe!r})), checkpoint_seconds=0)
"""


def test_kill_minus_nine_loses_nothing(data, tmp_path):
    """The process dies at a random moment of its second epoch, perhaps while it writes."""
    recipe = QUICK["all"]
    program = CHILD.format(
        tests=str(Path(__file__).parent),
        layout=json.dumps(data.layout.to_dict()),
        skeleton=json.dumps(data.skeleton.to_dict()),
        out=str(tmp_path / "killed"),
        recipe=json.dumps(recipe.to_dict()),
    )
    root = str(Path(__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": root}
    with subprocess.Popen([sys.executable, "-c", program], env=environment, stderr=subprocess.DEVNULL) as child:
        deadline = time.monotonic() + 60
        while not (tmp_path / "killed" / "curves.csv").is_file() and time.monotonic() < deadline:
            assert child.poll() is None
            time.sleep(0.002)
        child.send_signal(signal.SIGKILL)
    assert child.returncode == -signal.SIGKILL

    fit(data, tmp_path / "killed", recipe, resume=True)
    fit(data, tmp_path / "whole", recipe)
    assert_same_run(tmp_path / "whole", tmp_path / "killed")


def test_another_seed_is_another_training(data, tmp_path):
    recipe = replace(QUICK["footsel"], epochs=1)
    for seed in (0, 1):
        fit(data, tmp_path / str(seed), recipe, seed=seed)
    assert curve(tmp_path / "0") != curve(tmp_path / "1")


def test_a_training_learns_at_the_heights_that_its_recipe_shifts_by(data, tmp_path, monkeypatch):
    """Also where that is all that a recipe changes of its maps."""
    shifts, seen = [], training.as_seen
    monkeypatch.setattr(training, "as_seen", lambda *args, **named: shifts.append(args[4]) or seen(*args, **named))
    recipe = replace(QUICK["footsel"], epochs=1, noise=0.0, holes=0.0)
    for shift in (0.0, 0.02):
        fit(data, tmp_path / str(shift), replace(recipe, shift=shift))
    assert shifts and set(shifts) == {0.02}
    losses = [curve(tmp_path / str(shift))[0]["train_loss"] for shift in (0.0, 0.02)]
    assert losses[0] != losses[1]


def test_noise_makes_another_training_whose_labels_are_the_same(data, tmp_path):
    recipe = replace(QUICK["footsel"], epochs=1)
    heights = data.training.heights_tenth_mm.copy()
    for noise in (0.0, 1.0):
        fit(data, tmp_path / str(noise), replace(recipe, noise=noise))
    assert curve(tmp_path / "0.0") != curve(tmp_path / "1.0")
    assert np.array_equal(data.training.heights_tenth_mm, heights)


def test_a_folder_holds_one_training(data, tmp_path):
    recipe = replace(QUICK["footsel"], epochs=1)
    info = fit(data, tmp_path / "front", recipe)
    with pytest.raises(InputError, match="already holds a training; give --resume"):
        fit(data, tmp_path / "front", recipe)
    with pytest.raises(InputError, match="another configuration, with seed 0 and not 1;"):
        fit(data, tmp_path / "front", recipe, resume=True, seed=1)
    with pytest.raises(InputError, match=r"with recipe\.epochs 1 and not 2;"):
        fit(data, tmp_path / "front", replace(recipe, epochs=2), resume=True)
    with pytest.raises(InputError, match=r"with maps\.training 24 and not 6, maps\.validation 6 and not 24;"):
        fit(replace(data, training=data.validation, validation=data.training), tmp_path / "front", recipe, resume=True)
    # Nothing is left to do, so nothing is done.
    assert fit(data, tmp_path / "front", recipe, resume=True) == info


def test_a_loss_that_is_no_number_stops_the_training(data, tmp_path):
    with pytest.raises(InputError, match="lower the recipe's learning_rate"):
        fit(data, tmp_path / "front", replace(QUICK["paper"], learning_rate=1e30))


def test_missing_and_damaged_models_are_named(tmp_path):
    with pytest.raises(ModelError, match=r"there is no .*model\.safetensors"):
        load_network(tmp_path)
    (tmp_path / "model.safetensors").write_bytes(b"not a model")
    with pytest.raises(ModelError, match="damaged or foreign"):
        load_network(tmp_path)


def test_importing_the_package_loads_no_torch():
    program = "import sys, footsel.learning; print('torch' in sys.modules)"
    root = str(Path(__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": root}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
    also = program.replace("footsel.learning", "footsel.learning.erfnet")
    done = subprocess.run([sys.executable, "-c", also], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True", "this test could not fail"


def test_the_average_follows_the_weights(data, tmp_path):
    """With the average of one update it is the weights; a recipe without it uses the weights themselves."""
    info = fit(data, tmp_path / "plain", replace(QUICK["footsel"], epochs=1, ema_decay=0.0))
    fit(data, tmp_path / "average", replace(QUICK["footsel"], epochs=1, ema_decay=1e-9))
    plain, average = weights(tmp_path / "plain"), weights(tmp_path / "average")
    assert info["in_channels"] == len(QUICK["footsel"].planes)
    for name, tensor in plain.items():
        np.testing.assert_allclose(average[name].numpy(), tensor.numpy(), rtol=1e-5, atol=1e-7)


def test_the_threshold_is_chosen_on_bases_that_are_not_tilted_far(data, tmp_path, monkeypatch):
    pose = data.validation.pose.copy()
    pose[:, 3:5] = 0
    pose[[1, 4], 3] = 0.25
    asked = []

    def record(predictions, samples, layout, leg):
        asked.append(samples.pose)
        return threshold_curve(predictions, samples, layout, leg)

    monkeypatch.setattr(training, "threshold_curve", record)
    recipe = replace(QUICK["footsel"], epochs=1)
    fit(replace(data, validation=replace(data.validation, pose=pose)), tmp_path / "front", recipe)
    np.testing.assert_array_equal(asked, [pose[[0, 2, 3, 5]]])


def test_a_network_that_sees_the_hip_gets_no_ball_there(data, robot, obstacles, tmp_path):
    """Neither from the start nor in weights that had one."""
    data = replace(data, training=obstacles, layout=robot.layout)
    hip = replace(QUICK["footsel"], epochs=1, balls=4)
    without = tuple(name for name in hip.features if name != "hip")
    before = fit(data, tmp_path / "before" / "front", replace(hip, features=without, balls=5))
    new = fit(data, tmp_path / "new" / "front", hip)
    later = fit(data, tmp_path / "later" / "front", hip, start=tmp_path / "before")
    at_hip = [
        sum(link == 0 and abs(w) < 0.01 for link, (_, _, w) in zip(found["link"], found["balls"], strict=True))
        for found in (info["skeleton"] for info in (before, new, later))
    ]
    assert at_hip == [1, 0, 0]


def test_balls_are_fitted_once_and_kept(data, tmp_path, monkeypatch):
    """The fit is not done again by a training that goes on, nor the recipe's without it; weights keep their balls."""
    fits, fitted = [], training.with_fitted_balls
    monkeypatch.setattr(training, "with_fitted_balls", lambda *args, **named: fits.append(1) or fitted(*args, **named))
    recipe = replace(QUICK["footsel"], epochs=1, fit_balls=True)
    without = fit(data, tmp_path / "without" / "front", replace(recipe, fit_balls=False))
    assert not fits and without["skeleton"]["rises"] is None

    def die(*_):
        raise KilledError

    monkeypatch.setattr(training, "save_checkpoint", die)
    with pytest.raises(KilledError):
        fit(data, tmp_path / "with" / "front", recipe)
    monkeypatch.undo()
    monkeypatch.setattr(training, "with_fitted_balls", lambda *args, **named: fits.append(1) or fitted(*args, **named))
    info = fit(data, tmp_path / "with" / "front", recipe, resume=True)
    assert len(fits) == 1
    assert info["skeleton"]["balls"] != without["skeleton"]["balls"]
    assert load_network(tmp_path / "with" / "front")[1]["skeleton"] == info["skeleton"]

    on = fit(data, tmp_path / "on" / "front", recipe, start=tmp_path / "with")
    assert len(fits) == 1 and on["skeleton"] == info["skeleton"]
    # Those of weights of before there was a fit are fitted now.
    late = fit(data, tmp_path / "late" / "front", recipe, start=tmp_path / "without")
    assert len(fits) == 2 and late["skeleton"] == info["skeleton"]
