"""The loss: the paper's is torch's weighted cross-entropy; soft targets are probabilities; reasons count as asked."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from torch.nn import functional

from footsel.footholds import Reason
from footsel.learning.loss import LABEL_CLASS, FootholdLoss, map_weights, targets
from footsel.learning.recipe import Recipe

WEIGHT = np.linspace(1.4, 13, 14, dtype=np.float32)


@pytest.fixture
def logits(samples):
    return torch.randn(len(samples), 14, 40, 40, generator=torch.manual_seed(3))


def loss(samples, logits, reason_logits=None, **values):
    # Maps count alike, unless a test says otherwise.
    recipe = replace(Recipe.load("footsel"), **{"scarcity": 1.0, **values})
    return FootholdLoss(recipe, WEIGHT)(logits, reason_logits, samples)


def test_labels_are_the_papers_classes():
    assert LABEL_CLASS[[0, 19, 20, 254, 255]].tolist() == [0, 0, 1, 12, 13]
    assert targets(0).argmax(axis=1).tolist() == LABEL_CLASS.tolist() and targets(0).sum() == 256


def test_the_papers_loss_is_the_weighted_cross_entropy(samples, logits):
    labels = torch.from_numpy(LABEL_CLASS[samples.cost].astype(np.int64))
    expected = functional.cross_entropy(logits, labels, torch.from_numpy(WEIGHT))
    found = loss(samples, logits, ordinal=0.0, reason_weight=0.0, collision_weight=1.0)
    torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("spread", [0.05, 0.5, 1.0, 3.0])
def test_soft_targets(spread):
    table = targets(spread)
    np.testing.assert_allclose(table.sum(axis=1), 1, atol=1e-6)
    # Infeasible stays apart, on both sides.
    assert table[255].tolist() == [0] * 13 + [1] and not table[:255, 13].any()
    # The peak is the label's class, or its equal on the line between two.
    peaks = table[np.arange(255), LABEL_CLASS[:255]]
    np.testing.assert_allclose(peaks, table[:255].max(axis=1), rtol=1e-2)
    # Away from it probability falls on either side.
    for row, class_ in zip(table[:255, :13], LABEL_CLASS[:255], strict=True):
        assert (np.diff(row[class_:]) <= 1e-7).all() and (np.diff(row[: class_ + 1]) >= -1e-7).all()


def test_the_mean_of_soft_targets_resolves_finer_than_a_class():
    centres = (np.arange(13) + 0.5) * 255 / 13
    cost = np.arange(40, 215)  # The ends are drawn in, having no class beyond.
    assert np.abs(targets(0.5)[cost, :13] @ centres - cost).max() < 2.5
    assert np.abs(targets(0.0)[cost, :13] @ centres - cost).max() > 9


def test_a_neighbouring_class_is_less_wrong_than_a_far_one(samples):
    logits = torch.zeros(len(samples), 14, 40, 40)
    class_ = torch.from_numpy(np.minimum(LABEL_CLASS[samples.cost], 12).astype(np.int64))
    losses = {}
    for away in (1, 5):
        wrong = torch.where(class_ + away < 13, class_ + away, class_ - away)
        one = logits.scatter(1, wrong[:, None], 6.0)
        losses[away] = [float(loss(samples, one, ordinal=spread, reason_weight=0.0)) for spread in (0.0, 0.7)]
    assert losses[1][0] == pytest.approx(losses[5][0])
    assert losses[1][1] < losses[5][1] - 0.1


def test_a_collision_counts_as_so_many_cells(samples, logits):
    """Twice the weight is the same as every such cell there twice."""
    labels = torch.from_numpy(LABEL_CLASS[samples.cost].astype(np.int64))
    hits = torch.from_numpy(samples.reason == Reason.TERRAIN_COLLISION)
    assert hits.any()
    cells, classes = logits.permute(0, 2, 3, 1), labels
    twice = torch.cat([cells.reshape(-1, 14), cells[hits]]), torch.cat([classes.reshape(-1), classes[hits]])
    expected = functional.cross_entropy(*twice, torch.from_numpy(WEIGHT))
    found = loss(samples, logits, ordinal=0.0, reason_weight=0.0, collision_weight=2.0)
    torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-6)


def test_a_map_counts_the_more_the_fewer_footholds_it_has():
    reason = np.full((5, 40, 40), Reason.KINEMATIC_RANGE)
    for one, footholds in zip(reason.reshape(5, -1), (1600, 400, 100, 25, 0), strict=True):
        one[:footholds] = Reason.FEASIBLE
    assert map_weights(torch.from_numpy(reason), 3.0).tolist() == [0.5, 1, 2, 3, 3]
    assert map_weights(torch.from_numpy(reason), 50.0).tolist() == [0.5, 1, 2, 4, 20]


def test_scarcity_weighs_maps_and_nothing_else(samples, logits):
    """The loss is the mean of each map's own, by what the map's cells weigh and by how often it counts."""
    each, weight = [], []
    for number in range(len(samples)):
        one = samples.take(slice(number, number + 1))
        each.append(loss(one, logits[number : number + 1], ordinal=0.0, reason_weight=0.0, collision_weight=1.0))
        cells = WEIGHT[LABEL_CLASS[one.cost]].sum()
        weight.append(cells * map_weights(torch.from_numpy(one.reason), 2.0).item())
    assert len({w / c for w, c in zip(weight, WEIGHT[LABEL_CLASS[samples.cost]].sum(axis=(1, 2)), strict=True)}) > 1
    expected = torch.stack(each) @ torch.tensor(weight) / sum(weight)
    found = loss(samples, logits, ordinal=0.0, reason_weight=0.0, collision_weight=1.0, scarcity=2.0)
    torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-6, check_dtype=False)


def test_reasons_are_a_second_cross_entropy(samples, logits):
    reason_logits = torch.randn(len(samples), 5, 40, 40, generator=torch.manual_seed(4))
    alone = loss(samples, logits, collision_weight=1.0)
    both = loss(samples, logits, reason_logits, reason_weight=0.3, collision_weight=1.0)
    second = functional.cross_entropy(reason_logits, torch.from_numpy(samples.reason).long())
    torch.testing.assert_close(both, alone + 0.3 * second, rtol=1e-5, atol=1e-6)
