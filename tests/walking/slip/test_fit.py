"""The fit finds a known relation between features and slip, and keeps its laws."""

import numpy as np

from footsel.walking.slip import fit
from footsel.walking.slip.campaign import Trials
from footsel.walking.slip.trial import SLIP_CAP


def test_the_fit_follows_slip_that_grows_with_slope(monkeypatch):
    monkeypatch.setattr(fit, "STARTS", 1)
    rng = np.random.default_rng(0)
    k2 = rng.uniform(0, 1.2, 400)
    slip = np.broadcast_to((SLIP_CAP * np.minimum(k2, 1.0))[:, None, None], (400, 2, 8))
    names, seeds = np.full(400, "slopes"), np.zeros(400, dtype=np.int64)
    trials = Trials(k2 * rng.uniform(-0.2, 0.2, 400), k2, slip, np.ones(400, dtype=np.bool_), names, seeds)
    model = fit.fit_model(trials)
    assert fit.scores(model, trials)["spearman_worst_quarter"] > 0.9
    assert model.cost(0.0, 0.0) < 0.05
    assert (np.diff(model.cost(np.zeros(50), np.linspace(0, 1, 50))) >= -1e-6).all()
