"""Class weights shift the odds of the classes; a calibrated recipe shifts them back."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from footsel.learning.learner import Learner
from footsel.learning.recipe import Recipe


@pytest.mark.parametrize("name", ["paper", "footsel"])
def test_calibrated_weights_take_the_class_weights_out_of_the_odds(layout, skeleton, name) -> None:
    weight = np.linspace(1.5, 12.0, 14, dtype=np.float32)
    probabilities = {}
    for calibrated in (False, True):
        recipe = replace(Recipe.load(name), calibrated=calibrated)
        learner = Learner(recipe, layout, weight, seed=0, skeleton=skeleton)
        maps = torch.rand(1, learner.net.in_channels, 40, 40, generator=torch.manual_seed(1))
        with torch.no_grad():
            probabilities[calibrated] = learner.usable_network()(maps).softmax(1)
    odds = probabilities[False] / probabilities[True]
    relative = odds / odds[:, :1]
    expected = torch.from_numpy(weight / weight[0]).reshape(1, -1, 1, 1)
    torch.testing.assert_close(relative, expected.expand_as(relative), rtol=1e-3, atol=1e-4)


def test_a_weighted_optimum_is_calibrated_again() -> None:
    """The minimiser of the weighted cross-entropy over one cell's logits, less ln(w), is the data's distribution."""
    shares = torch.tensor([0.05, 0.15, 0.8])
    weight = torch.tensor([9.0, 5.0, 1.6])
    logits = torch.zeros(3, requires_grad=True)
    optimiser = torch.optim.LBFGS([logits], max_iter=200)

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        loss = -(shares * weight * logits.log_softmax(0)).sum()
        loss.backward()
        return loss

    optimiser.step(closure)
    torch.testing.assert_close((logits.detach() - weight.log()).softmax(0), shares, rtol=1e-3, atol=1e-3)
