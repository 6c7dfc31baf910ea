"""Channels that nothing hears go without a trace; of the rest those that are heard most stay."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from footsel.errors import ModelError
from footsel.learning.learner import Learner
from footsel.learning.pruning import narrowed
from footsel.learning.recipe import Recipe
from footsel.learning.train import fit
from footsel.learning.warm_start import start_from

WEIGHTS = np.linspace(1.4, 13, 14, dtype=np.float32)
WIDE = replace(Recipe.load("footsel"), cells=(12, 10, 8), balls=0, epochs=1, batch_size=8)
NARROW = replace(WIDE, cells=(12, 7, 5))


@pytest.fixture
def learners(layout, data):
    return [Learner(recipe, layout, WEIGHTS, seed=1, skeleton=data.skeleton) for recipe in (WIDE, NARROW)]


def test_channels_that_nothing_hears_go_without_a_trace(learners, samples):
    wide, narrow = (learner.net.eval() for learner in learners)
    silent = {"cells.2.0.weight": [0, 4, 9], "head.weight": [1, 2, 7], "reason_head.weight": [1, 2, 7]}
    with torch.no_grad():
        for name, channels in silent.items():
            wide.state_dict()[name][:, channels] = 0
        for name, tensor in wide.state_dict().items():
            if name.endswith("running_mean"):
                tensor.normal_()
        maps = learners[0].encode(samples)
        expected = wide(maps)
        narrow.load_state_dict(narrowed(wide.state_dict(), NARROW.cells))
        torch.testing.assert_close(narrow(maps), expected, rtol=1e-5, atol=1e-5)


def test_a_channel_counts_by_how_loud_it_is_and_how_much_it_is_heard(learners):
    weights = learners[0].net.state_dict()
    for name in ("cells.1.1.weight", "cells.2.0.weight"):
        weights[name] = torch.ones_like(weights[name])
    weights["cells.1.1.weight"][3], weights["cells.2.0.weight"][:, 5] = 4.0, 3.0
    weights["cells.1.0.bias"] = torch.arange(10.0)
    assert narrowed(weights, (12, 2, 8))["cells.1.0.bias"].tolist() == [3.0, 5.0]


def test_as_many_channels_are_the_same_network(learners):
    weights = learners[0].net.state_dict()
    same = narrowed(weights, WIDE.cells)
    assert all(torch.equal(same[name], tensor) for name, tensor in weights.items()) and len(same) == len(weights)


def test_a_narrower_training_begins_with_a_wider_one(data, layout, tmp_path):
    run = fit(data, tmp_path / "wide" / "front", WIDE)
    began = fit(data, tmp_path / "narrow" / "front", NARROW, start=tmp_path / "wide")
    assert began["started_from"]["epochs"] == run["epochs_done"]
    learner = Learner(WIDE, layout, WEIGHTS, seed=1, skeleton=data.skeleton)
    with pytest.raises(ModelError, match=r"has cells .* the recipe"):
        start_from(learner, tmp_path / "narrow", "front")
