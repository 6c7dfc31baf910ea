"""Batches: the same numbers as the runtime's encoding, the same order for the same seed; the paper's class weights."""

import itertools

import numpy as np
import pytest
import torch

from footsel.footholds.encoding import PLANES, InputEncoding
from footsel.learning.batches import BatchEncoder, shuffled_batches
from footsel.learning.loss import class_shares, class_weights


@pytest.mark.parametrize("quantised", [True, False])
@pytest.mark.parametrize("planes", [("height",), PLANES, ("pitch", "height")])
def test_encoding_by_table_equals_the_runtimes(samples, planes, quantised):
    samples.heights_tenth_mm[0, :2, :3] = [[-32767, 32767, -32768], [0, -8500, -8501]]
    encoding = InputEncoding(planes, quantised, height_range=0.85)
    batch = BatchEncoder(encoding)(samples)
    np.testing.assert_array_equal(batch.numpy(), encoding.encode(samples.heights(), samples.roll, samples.pitch))
    assert batch.is_contiguous(memory_format=torch.channels_last)


def test_an_epoch_visits_every_map_once_in_an_order_of_its_own():
    epochs = [shuffled_batches(10, 4, seed, epoch) for seed, epoch in [(0, 0), (0, 0), (0, 1), (1, 0)]]
    orders = [np.concatenate(batches).tolist() for batches in epochs]
    assert [len(batch) for batch in epochs[0]] == [4, 4, 2]
    assert all(sorted(order) == list(range(10)) for order in orders)
    assert orders[0] == orders[1]
    assert all(a != b for a, b in itertools.combinations(orders[1:], 2))


def test_class_weights_by_hand():
    cost = np.full((1, 40, 40), 255, dtype=np.uint8)
    cost[0, :10] = 0  # a quarter of class 0, the rest of class 13
    shares = class_shares(cost)
    assert shares[0] == 0.25 and shares[13] == 0.75 and shares.sum() == 1
    weights = class_weights(shares, "paper")
    assert weights[0] == pytest.approx(1 / np.log(1.33))
    assert weights[13] == pytest.approx(1 / np.log(1.83))
    # The range that the constant 1.08 leaves.
    assert weights[5] == pytest.approx(12.99, abs=0.01)
    assert class_weights(np.eye(14)[3], "paper")[3] == pytest.approx(1.37, abs=0.01)
    assert class_weights(shares, "none").tolist() == [1] * 14
