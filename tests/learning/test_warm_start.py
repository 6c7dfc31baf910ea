"""A training goes on from a released model: the same function before the first update, in both modes of the norms."""

import numpy as np
import pytest
import torch
from torch import nn

from footsel.errors import ModelError
from footsel.footholds.encoding import InputEncoding
from footsel.learning import warm_start
from footsel.learning.learner import Learner
from footsel.learning.recipe import Recipe
from footsel.learning.warm_start import lineage, start_from_release
from footsel.runtime.model_folder import find_model_folder, load_networks

WEIGHTS = np.linspace(1.4, 13, 14, dtype=np.float32)


@pytest.fixture(scope="module")
def released():
    return load_networks(find_model_folder("anymal_b"))["hind"]


@pytest.fixture
def learner(released):
    return Learner(Recipe.load("footsel"), released.contract.encoding, WEIGHTS, seed=3)


def released_probabilities(released, samples):
    return released.probabilities(samples.heights(), samples.roll, samples.pitch)


def test_the_weights_to_use_are_the_release_s_function(learner, released, samples):
    start_from_release(learner, "anymal_b", "hind", samples)
    net = learner.net
    net.load_state_dict(dict(learner.weights()))
    with torch.inference_mode():
        logits = net.eval()(learner.encode(samples))
    expected = released_probabilities(released, samples)
    np.testing.assert_allclose(torch.softmax(logits, 1).numpy(), expected, atol=2e-4)


def test_batch_statistics_give_the_same_as_running_ones(learner, samples):
    start_from_release(learner, "anymal_b", "hind", samples)
    encoded = learner.encode(samples)
    with torch.inference_mode():
        running = learner.net.eval()(encoded)
        learner.net.train()
        for module in learner.net.modules():
            if isinstance(module, nn.Dropout2d):
                module.eval()
        by_batch = learner.net(encoded)
    assert (running - by_batch).abs().max() < 1e-2 * running.abs().max()


def test_training_begins_with_the_tilt_of_the_class_weights(learner, samples):
    start_from_release(learner, "anymal_b", "hind", samples)
    tilt = learner.net.decoder[-1].bias.detach() - learner.weights()["decoder.6.bias"]
    np.testing.assert_allclose(tilt.numpy(), np.log(WEIGHTS), rtol=1e-5)


def test_the_first_loss_is_that_of_a_trained_network(learner, samples, monkeypatch):
    """And a norm left as it was initialised would be noticed."""
    encoding = learner.encode.encoding

    def first_loss():
        fresh = Learner(Recipe.load("footsel"), encoding, WEIGHTS, seed=3)
        start_from_release(fresh, "anymal_b", "hind", samples)
        fresh.net.load_state_dict(dict(fresh.weights()))
        with torch.inference_mode():
            return fresh.net.eval()(fresh.encode(samples))

    good = first_loss()
    monkeypatch.setattr(nn.Module, "register_forward_pre_hook", lambda *_: _Nothing())
    assert (first_loss() - good).abs().max() > 0.1


class _Nothing:
    def remove(self):
        pass


def test_lineage_names_file_and_data(released):
    said = lineage("anymal_b", "hind")
    assert said["dataset_sha256"] == released.contract.dataset_sha256
    assert len(said["sha256"]) == 64 and said["sha256"] != lineage("anymal_b", "front")["sha256"]


def test_other_planes_are_refused(samples):
    learner = Learner(Recipe.load("paper"), InputEncoding(), WEIGHTS, seed=0)
    with pytest.raises(ModelError, match="planes"):
        start_from_release(learner, "anymal_b", "front", samples)


def test_another_architecture_is_refused(learner, samples, monkeypatch):
    monkeypatch.setattr(warm_start, "_unfold", lambda *_: {}["encoder.0.convolution.weight"])
    with pytest.raises(ModelError, match="no plain ERFNet"):
        start_from_release(learner, "anymal_b", "front", samples)
