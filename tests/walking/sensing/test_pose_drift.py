"""The drift is as large as it says, and says how large it is."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from footsel.walking.sensing import DriftRates, PoseDrift
from footsel.walking.state import RobotState

RATES = DriftRates(position=0.02, yaw=0.03, tilt=0.01)


def at(time, base):
    return RobotState(
        time, base, np.array([0.1, 0.0, 0.0]), np.zeros(3), np.arange(12.0), np.zeros(12), np.ones((4, 3))
    )


def way(steps=20, length=2.0):
    """States along a bend."""
    for k in range(steps + 1):
        base = np.eye(4)
        angle = 0.5 * k / steps
        base[:3, :3] = pin.exp3(np.array([0, 0, angle]))
        base[:3, 3] = length * np.sin(angle) / 0.5, length * (1 - np.cos(angle)) / 0.5, 0.5
        yield at(0.4 * k, base)


def errors(estimate, truth):
    """x, y, z and a rotation vector along W's axes."""
    turn = pin.log3(estimate.base[:3, :3] @ truth.base[:3, :3].T)
    return np.concatenate([estimate.base[:3, 3] - truth.base[:3, 3], turn])


def test_the_covariance_is_that_of_the_errors():
    samples = []
    for seed in range(800):
        drift = PoseDrift(np.random.default_rng(seed), RATES)
        for truth in way():
            estimate = drift.estimate(truth)
        samples.append(errors(estimate, truth))
    told, found = drift.covariance(), np.cov(np.array(samples).T)
    assert np.allclose(np.diag(found), np.diag(told), rtol=0.2)
    scale = np.sqrt(np.outer(np.diag(told), np.diag(told)))
    assert np.abs((found - told) / scale).max() < 0.2
    assert np.abs(np.mean(samples, axis=0)).max() < 0.005
    # After 2 m of way.
    assert np.isclose(told[2, 2], 2 * RATES.position**2, rtol=0.01)
    assert np.isclose(told[5, 5], 2 * RATES.yaw**2, rtol=0.01)


def test_a_robot_that_stands_does_not_drift():
    drift, truth = PoseDrift(np.random.default_rng(0), RATES), next(iter(way()))
    first = drift.estimate(truth)
    assert np.allclose(first.base[:3, 3], truth.base[:3, 3])
    for k in range(500):
        last = drift.estimate(replace(truth, time=0.1 * k))
    assert np.allclose(last.base[:3, 3], truth.base[:3, 3])
    assert 0 < np.abs(errors(last, truth)[3:5]).max() < 5 * RATES.tilt
    assert abs(errors(last, truth)[5]) < RATES.tilt**2


def test_without_rates_the_estimate_is_the_truth():
    drift = PoseDrift(np.random.default_rng(0), DriftRates(0, 0, 0))
    for truth in way():
        estimate = drift.estimate(truth)
        assert np.allclose(estimate.base, truth.base)
        assert np.allclose(estimate.foot_forces, truth.foot_forces)
    assert not drift.covariance().any()


def test_what_the_body_feels_is_not_changed_by_where_it_believes_to_be():
    drift = PoseDrift(np.random.default_rng(3), RATES)
    for truth in way():
        estimate = drift.estimate(truth)
    assert estimate.joints is truth.joints
    for name in ("linear", "angular"):
        felt = [state.base[:3, :3].T @ getattr(state, name) for state in (truth, estimate)]
        assert np.allclose(*felt)
    assert np.allclose(truth.foot_forces @ truth.base[:3, :3], estimate.foot_forces @ estimate.base[:3, :3])


@pytest.mark.parametrize(("seed", "same"), [(7, True), (8, False)])
def test_the_same_seed_drifts_the_same_way(seed, same):
    one, other = (PoseDrift(np.random.default_rng(each), RATES) for each in (7, seed))
    ends = [[drift.estimate(truth) for truth in way()][-1].base for drift in (one, other)]
    assert np.array_equal(*ends) == same
