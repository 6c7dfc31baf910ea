"""A training goes on from another's weights: the same function before the first update, from a run or a release."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from footsel.errors import ModelError
from footsel.learning.ball_choice import with_best_balls
from footsel.learning.checkpoint import load_network, released_weights
from footsel.learning.footnet import input_names
from footsel.learning.learner import Learner
from footsel.learning.recipe import Recipe
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.train import fit
from footsel.learning.warm_start import find_weights, lineage, start_from
from footsel.runtime.model_folder import SUMS_FILE

WEIGHTS = np.linspace(1.4, 13, 14, dtype=np.float32)
RECIPES = {
    "paper": replace(Recipe.load("paper"), epochs=1, batch_size=8),
    "footsel": replace(Recipe.load("footsel"), epochs=1, batch_size=8, reason_weight=0.2),
}


@pytest.fixture
def few_balls(data):
    """The skeleton with the balls that the run gets."""
    return with_best_balls(data.skeleton, data.training, data.layout, RECIPES["footsel"].balls)


@pytest.fixture(params=RECIPES)
def recipe(request):
    return RECIPES[request.param]


@pytest.fixture
def run(data, recipe, tmp_path):
    fit(data, tmp_path / "run" / "front", recipe)
    return tmp_path / "run"


@pytest.fixture
def release(run, tmp_path):
    """A model folder, as far as a training looks into it."""
    net, info = load_network(run / "front")
    (tmp_path / "release").mkdir()
    (tmp_path / "release" / SUMS_FILE).write_text("")
    (tmp_path / "release" / "front.safetensors").write_bytes(released_weights(net.state_dict(), info))
    return tmp_path / "release"


def logits(net, maps):
    with torch.inference_mode():
        return net(maps)


def test_the_weights_to_use_are_those_of_the_run(run, recipe, layout, few_balls, samples):
    learner = Learner(recipe, layout, WEIGHTS, seed=3, skeleton=few_balls)
    maps = learner.encode(samples)
    expected = logits(load_network(run / "front")[0], maps)
    assert (logits(learner.usable_network(), maps) - expected).abs().max() > 0.1
    start_from(learner, run, "front")
    torch.testing.assert_close(logits(learner.usable_network(), maps), expected, rtol=1e-4, atol=1e-4)


def test_training_begins_with_the_tilt_of_the_class_weights(run, recipe, layout, few_balls):
    learner = Learner(replace(recipe, calibrated=True), layout, WEIGHTS, seed=3, skeleton=few_balls)
    start_from(learner, run, "front")
    bias = learner.net.class_bias
    tilt = learner.net.get_parameter(bias).detach() - learner.weights()[bias]
    np.testing.assert_allclose(tilt.numpy(), np.log(WEIGHTS), rtol=1e-4)


def test_a_release_s_weights_are_half_as_large_and_nearly_the_same(run, release, recipe, layout, few_balls, samples):
    learner = Learner(recipe, layout, WEIGHTS, seed=3, skeleton=few_balls)
    maps = learner.encode(samples)
    start_from(learner, release, "front")
    net = load_network(run / "front")[0]
    for name, tensor in learner.usable_network().state_dict().items():
        torch.testing.assert_close(tensor, net.state_dict()[name], rtol=2**-8, atol=1e-5)
    expected = logits(net, maps)
    assert (logits(learner.usable_network(), maps) - expected).abs().max() < 0.05 * expected.abs().max()
    files = [path.read_bytes() for path in (release / "front.safetensors", run / "front" / "model.safetensors")]
    # Without their headers, whose length comes first in a file.
    sizes = [len(content) - int.from_bytes(content[:8], "little") for content in files]
    assert sizes[0] < 0.6 * sizes[1]


def test_every_place_of_weights_is_found(run, release):
    model = run / "front" / "model.safetensors"
    assert find_weights(run, "front") == find_weights(run / "front", "front") == find_weights(model, "front") == model
    assert find_weights(release, "front") == release / "front.safetensors"
    with pytest.raises(ModelError, match="no weights to go on from"):
        find_weights(release, "hind")
    with pytest.raises(ModelError, match="no model"):
        find_weights(run / "nowhere", "front")


def test_a_run_says_what_it_began_with(data, run, recipe, tmp_path):
    said = lineage(run, "front")
    assert len(said["sha256"]) == 64 and said["dataset_sha256"] == "0" * 64 and said["epochs"] == 1
    assert said["recipe"] == recipe.name and said["started_from"] is None
    second = fit(data, tmp_path / "second" / "front", recipe, start=run)
    assert second["started_from"] == said
    # And what that had begun with.
    assert lineage(tmp_path / "second", "front")["started_from"] == said
    with pytest.raises(ModelError, match="trained for the front legs, not hind"):
        lineage(run / "front", "hind")


def test_a_second_sitting_is_resumed_like_any_other(data, run, recipe, tmp_path):
    """The start is read once; what is resumed is the checkpoint."""
    longer = replace(recipe, epochs=2)
    whole = fit(data, tmp_path / "whole", longer, start=run)
    assert fit(data, tmp_path / "whole", longer, resume=True, start=run) == whole


def test_a_second_sitting_keeps_the_balls_of_the_first(data, tmp_path):
    """Whichever its own maps would choose: weights belong to them."""
    first = fit(data, tmp_path / "first" / "front", RECIPES["footsel"])
    other = replace(data, skeleton=replace(data.skeleton, balls=data.skeleton.balls + 0.01))
    second = fit(other, tmp_path / "second" / "front", RECIPES["footsel"], start=tmp_path / "first")
    assert second["skeleton"] == first["skeleton"]
    assert fit(other, tmp_path / "third" / "front", RECIPES["footsel"])["skeleton"] != first["skeleton"]


def test_a_ball_that_is_left_out_takes_its_weights_with_it(data, layout, tmp_path, samples):
    """The others keep theirs: a network that gives the ball no weight stays what it was."""
    recipe = replace(RECIPES["footsel"], balls=3)
    fit(data, tmp_path / "front", recipe)
    whole = LegSkeleton.from_dict(load_network(tmp_path / "front")[1]["skeleton"])
    kept = [0, 2]
    fewer = replace(whole, link=whole.link[kept], balls=whole.balls[kept], radius=whole.radius[kept])
    old, new = (
        Learner(replace(recipe, balls=len(skeleton.radius)), layout, WEIGHTS, seed=3, skeleton=skeleton)
        for skeleton in (whole, fewer)
    )
    start_from(old, tmp_path, "front")
    start_from(new, tmp_path, "front")
    dropped = input_names(recipe.features, whole).index(
        (set(input_names(recipe.features, whole)) - set(input_names(recipe.features, fewer))).pop()
    )
    with torch.no_grad():
        for weights in (old.net.get_parameter("first.weight"), old.average["first.weight"]):
            weights[:, dropped] = 0
    found, expected = (logits(each.usable_network(), each.encode(samples)) for each in (new, old))
    torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-5)


def test_more_features_and_planes_change_nothing_at_first(data, layout, few_balls, tmp_path, samples):
    after = RECIPES["footsel"]
    before = replace(
        after,
        planes=tuple(name for name in after.planes if name != "above"),
        features=tuple(name for name in after.features if name != "hip"),
    )
    assert set(before.features) < set(after.features) and set(before.planes) < set(after.planes)
    fit(replace(data, skeleton=few_balls), tmp_path / "front", before)
    learners = [Learner(recipe, layout, WEIGHTS, seed=3, skeleton=few_balls) for recipe in (before, after)]
    for learner in learners:
        start_from(learner, tmp_path, "front")
    old, new = (logits(learner.usable_network(), learner.encode(samples)) for learner in learners)
    torch.testing.assert_close(new, old, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "key", "value"),
    [
        ("paper", "planes", ("height", "unknown")),
        ("footsel", "cells", (16, 8)),
        ("footsel", "features", ("footing",)),
        ("footsel", "balls", 9),
    ],
)
def test_another_network_is_refused(data, layout, few_balls, tmp_path, name, key, value):
    fit(data, tmp_path / "front", RECIPES[name])
    learner = Learner(replace(RECIPES[name], **{key: value}), layout, WEIGHTS, seed=0, skeleton=few_balls)
    with pytest.raises(ModelError, match=f"has {key} .* the recipe"):
        start_from(learner, tmp_path, "front")


def test_the_reasons_may_come_and_go(data, layout, few_balls, tmp_path, samples):
    """They are for training: weights with them serve a recipe without, and the other way round."""
    for before, after in ((0.2, 0.0), (0.0, 0.2)):
        folder = tmp_path / str(before)
        fit(data, folder / "front", replace(RECIPES["footsel"], reason_weight=before))
        learner = Learner(replace(RECIPES["footsel"], reason_weight=after), layout, WEIGHTS, seed=0, skeleton=few_balls)
        start_from(learner, folder, "front")
        maps = learner.encode(samples)
        expected = logits(load_network(folder / "front")[0], maps)
        torch.testing.assert_close(logits(learner.usable_network(), maps), expected, rtol=1e-4, atol=1e-4)


def test_weights_that_do_not_fit_are_named(layout, few_balls, recipe):
    learner = Learner(recipe, layout, WEIGHTS, seed=0, skeleton=few_balls)
    with pytest.raises(RuntimeError, match="do not fit"):
        learner.adopt(dict(list(learner.weights().items())[1:]))
