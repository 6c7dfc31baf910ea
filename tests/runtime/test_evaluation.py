"""Decoding of probabilities, against a plain loop."""

import numpy as np

from footsel.footholds.cost import expected_cost
from footsel.runtime.evaluation import decode


def test_decoding_is_the_written_rule():
    rng = np.random.default_rng(0)
    logits = rng.normal(0, 2, (2, 14, 4, 4))
    probabilities = (np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True)).astype(np.float32)
    known = rng.random((2, 4, 4)) > 0.2
    result = decode(probabilities, known, 0.1)
    assert 0 < result.feasible.sum() < known.sum()
    for n, i, j in np.ndindex(2, 4, 4):
        p = probabilities[n, :, i, j].astype(float)
        feasible = known[n, i, j] and p[13] < 0.1
        assert result.feasible[n, i, j] == feasible
        assert result.class_[n, i, j] == (np.argmax(p[:13]) if feasible else 13)
        assert result.cost[n, i, j] == (expected_cost(probabilities)[n, i, j] if feasible else 255)
        assert result.confidence[n, i, j] == np.float32(1 - p[13] if known[n, i, j] else 0)
    assert (result.class_.dtype, result.cost.dtype, result.feasible.dtype) == (np.uint8, np.float32, np.bool_)
    assert result.confidence.dtype == np.float32


def test_certain_probabilities_make_no_nan():
    probabilities = np.zeros((1, 14, 2, 2), dtype=np.float32)
    probabilities[:, 13] = 1
    judged = decode(probabilities, np.ones((1, 2, 2), dtype=bool), 1.0)
    assert not judged.feasible.any()
    assert (judged.cost == 255).all() and (judged.confidence == 0).all()
