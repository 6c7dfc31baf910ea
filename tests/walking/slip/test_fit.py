"""The fit finds a known relation between features and slip, and keeps its laws."""

import numpy as np

from footsel.walking.slip import fit
from footsel.walking.slip.campaign import COURSE_RESOLUTION, PATCH, Trials
from footsel.walking.slip.trial import SLIP_CAP


def planes(slopes: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(n, PATCH, PATCH) patches of these slopes, each towards another side."""
    along = (np.arange(PATCH) - PATCH // 2) * COURSE_RESOLUTION
    x, y = np.meshgrid(along, along, indexing="ij")
    turn = rng.uniform(0, 2 * np.pi, (len(slopes), 1, 1))
    return slopes[:, None, None] * (np.cos(turn) * x + np.sin(turn) * y)


def test_the_fit_follows_slip_that_grows_with_slope(monkeypatch):
    monkeypatch.setattr(fit, "STARTS", 1)
    rng = np.random.default_rng(0)
    slopes = rng.uniform(0, 1.0, 400)
    slip = np.broadcast_to((SLIP_CAP * slopes)[:, None, None], (400, 2, 8))
    names, seeds = np.full(400, "slopes"), np.zeros(400, dtype=np.int64)
    trials = Trials(planes(slopes, rng), slip, np.ones(400, dtype=np.bool_), names, seeds)
    model = fit.fit_model(trials)
    assert fit.scores(model, trials)["spearman_worst_quarter"] > 0.9
    assert model.cost(0.0, 0.0) < 0.05
    assert (np.diff(model.cost(np.zeros(50), np.linspace(0, 1, 50))) >= -1e-6).all()


def test_worst_quarter_of_the_pushes_decides():
    slip = np.zeros((3, 2, 8))
    slip[1, 0, :4] = SLIP_CAP  # a quarter of the sixteen
    slip[2] = SLIP_CAP / 2
    np.testing.assert_allclose(fit.slip_cost(slip), [0, 1, 0.5])
