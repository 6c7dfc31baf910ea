"""Variances of motion and attitude against samples of the errors that they describe."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from footsel.mapping.grid import Grid, moved
from footsel.mapping.motion import attitude_variance, motion_variance


def turned(yaw, x=0.0, y=0.0):
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0.5], [0, 0, 0, 1]])


def test_attitude_lifts_points_as_small_turns_do():
    rng = np.random.default_rng(0)
    spread = rng.normal(size=(2, 2)) * 0.005
    covariance = np.zeros((6, 6))
    covariance[3:5, 3:5] = spread @ spread.T
    base, points = turned(0.4, 1.0, -2.0), rng.uniform(-2, 2, (5, 2))
    a, b = spread @ rng.normal(size=(2, 200_000))
    lever = points - [1.0, -2.0]
    lifts = a * lever[:, 1:] - b * lever[:, :1]
    assert np.allclose(attitude_variance(points, base, covariance), lifts.var(axis=1), rtol=0.02)


def test_a_drifting_pose_makes_places_as_uncertain_as_samples_of_it():
    """Odometry: each step adds errors of its own, and an error of yaw turns all steps that follow."""
    rng = np.random.default_rng(1)
    samples, travel = 200_000, np.array([0.3, -0.1])
    before = rng.normal(size=(samples, 4)) * [0.02, 0.01, 0.01, 0.01]
    step = rng.normal(size=(samples, 4)) * [0.004, 0.002, 0.003, 0.002]
    after = before + step
    after[:, 0] += -before[:, 3] * travel[1]
    after[:, 1] += before[:, 3] * travel[0]

    def covariance(errors):
        full = np.zeros((6, 6))
        full[np.ix_([0, 1, 2, 5], [0, 1, 2, 5])] = np.cov(errors.T)
        return full

    growth = motion_variance(turned(0), covariance(before), turned(0, *travel), covariance(after))
    assert np.allclose([growth.x, growth.y, growth.height, growth.yaw], [16e-6, 4e-6, 9e-6, 4e-6], rtol=0.05, atol=1e-7)
    # A cell 2 m ahead is carried across by the yaw, one to the left to and fro.
    assert np.allclose(growth.of_places(np.array([2.0, 0.0])), [growth.x, growth.y + 4 * growth.yaw])
    assert np.allclose(growth.of_places(np.array([0.0, 3.0])), [growth.x + 9 * growth.yaw, growth.y])


def test_a_pose_that_becomes_more_certain_takes_nothing_away():
    growth = motion_variance(turned(0), np.eye(6) * 1e-4, turned(0.1, 0.2), np.zeros((6, 6)))
    assert (growth.height, growth.x, growth.y, growth.yaw) == (0, 0, 0, 0)


@given(st.integers(-9, 9), st.integers(-9, 9), st.integers(-9, 9), st.integers(-9, 9))
@settings(max_examples=60, deadline=None)
def test_a_moved_layer_keeps_its_places_in_the_world(i, j, di, dj):
    layer = np.arange(64.0).reshape(8, 8)
    grid, other = Grid(8, 0.1, np.array([i, j])), Grid(8, 0.1, np.array([i + di, j + dj]))
    after = moved(layer, np.array([di, dj]), np.nan)
    places, other_places = (np.rint(each.centres(np.arange(64)) * 100).astype(int) for each in (grid, other))
    known = dict(zip(map(tuple, places), layer.flat, strict=True))
    for place, value in zip(map(tuple, other_places), after.flat, strict=True):
        assert np.array_equal(value, known.get(place, np.nan), equal_nan=True)
