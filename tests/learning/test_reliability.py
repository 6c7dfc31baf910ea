"""Reliability diagrams: calibrated and miscalibrated coins."""

import numpy as np
import pytest

from footsel.learning.reliability import EDGES, Reliability


def test_by_hand():
    reliability = Reliability()
    assert reliability.result() == {"ece": None, "bins": []}
    reliability.update([0.5, 0.51, 0.49], [True, False, False])
    reliability.update([[0.0], [1.0]], [[False], [True]])
    result = reliability.result()
    assert [each["count"] for each in result["bins"]] == [1, 1, 2, 1]
    assert [each["frequency"] for each in result["bins"]] == [0.0, 0.0, 0.5, 1.0]
    assert [each["probability"] for each in result["bins"]] == pytest.approx([0.0, 0.49, 0.505, 1.0])
    assert result["ece"] == pytest.approx((0.49 + 2 * 0.005) / 5)
    assert (result["bins"][0]["from"], result["bins"][-1]["to"]) == (0.0, 1.0)


def test_fair_coins_are_calibrated_and_bold_ones_are_not():
    rng = np.random.default_rng(0)
    truth = rng.uniform(0, 1, 400_000)
    happened = rng.random(truth.shape) < truth
    fair, bold = Reliability(), Reliability()
    fair.update(truth, happened)
    bold.update(np.clip(truth + 0.2 * (truth - 0.5), 0, 1), happened)
    assert fair.result()["ece"] < 0.005
    # The mean of 0.2 |p - 0.5| over p even in [0, 1] is 0.05; clipping takes a little of it.
    assert 0.04 < bold.result()["ece"] < 0.05


def test_edges_part_the_unit_interval():
    assert (np.diff(EDGES) > 0).all() and EDGES[0] > 0 and EDGES[-1] < 1
    np.testing.assert_allclose(EDGES + EDGES[::-1], 1, atol=1e-4)
