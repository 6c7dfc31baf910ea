"""Balls that learn where collisions are: they begin where they were, and find what made the labels."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from footsel.footholds import Reason
from footsel.footholds.encoding import PLANES, InputEncoding
from footsel.learning.ball_fit import CollisionTrial, with_fitted_balls
from footsel.learning.clearance import LegClearance
from footsel.learning.posture import Posture
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt


@pytest.fixture(scope="module")
def skeleton(robot):
    whole = LegSkeleton.of(robot, "LF")
    kept = [1, 3, 5, 9, 12]
    return replace(whole, link=whole.link[kept], balls=whole.balls[kept], radius=whole.radius[kept])


def inputs(robot, samples):
    encode = InputEncoding(PLANES, False, robot.layout.height_range).encode
    return torch.from_numpy(encode(samples.heights(), samples.roll, samples.pitch))


def clearances(robot, skeleton, maps):
    """(n, balls, 1600) of the layer that a network has."""
    tilt = Tilt(PLANES)(maps)
    posture = Posture(robot.layout, skeleton)(maps[:, :1].flatten(2), tilt)
    return LegClearance(robot.layout, skeleton)(posture, tilt, maps[:, :1], 1 - maps[:, 1:2])


def seen_by(trial, maps):
    """The clearances that reach the trial's network."""
    caught = []
    hook = trial.net.register_forward_hook(lambda _, given, __: caught.append(given[0]))
    trial(maps)
    hook.remove()
    return caught[0][:, : len(trial.balls)]


def test_it_begins_with_the_balls_as_they_are(robot, skeleton, obstacles):
    trial, maps = CollisionTrial(robot.layout, skeleton), inputs(robot, obstacles.take(slice(0, 5)))
    expected = clearances(robot, skeleton, maps)
    torch.testing.assert_close(seen_by(trial, maps), expected, rtol=0, atol=0)
    same = trial.skeleton()
    assert skeleton.rises is None
    assert same.rises is not None
    np.testing.assert_array_equal(same.balls, skeleton.balls)
    torch.testing.assert_close(clearances(robot, same, maps), expected, rtol=0, atol=1e-6)


def test_what_is_learnt_is_what_a_network_gets(robot, skeleton, obstacles):
    """Balls that moved and rises that grew clear the same in the trial and in the layer made of them."""
    trial, maps = CollisionTrial(robot.layout, skeleton), inputs(robot, obstacles.take(slice(0, 5)))
    with torch.no_grad():
        trial.balls += torch.linspace(-0.03, 0.03, trial.balls.numel()).reshape(trial.balls.shape)
        trial.rises[:, :2] += 0.1
    moved = trial.skeleton()
    assert np.abs(moved.balls - skeleton.balls).max() == pytest.approx(0.03)
    found = clearances(robot, moved, maps)
    torch.testing.assert_close(seen_by(trial, maps), found, rtol=0, atol=1e-5)
    assert (found - clearances(robot, skeleton, maps)).abs().mean() > 0.05


def test_balls_find_where_the_labels_came_from(robot, skeleton, obstacles):
    """Labels of balls that lie 2 cm elsewhere: they go there, at least half of the way."""
    aside = np.random.default_rng(0).normal(size=skeleton.balls.shape)
    target = replace(skeleton, balls=skeleton.balls + 0.02 * aside / np.linalg.norm(aside, axis=1, keepdims=True))
    collides = (clearances(robot, target, inputs(robot, obstacles)).amin(dim=1) < 0).reshape(-1, 40, 40).numpy()
    in_range = np.isin(obstacles.reason, (Reason.FEASIBLE, Reason.TERRAIN_COLLISION))
    assert 0.05 < collides[in_range].mean() < 0.7
    reason = np.where(collides, Reason.TERRAIN_COLLISION, Reason.FEASIBLE).astype(np.uint8)
    labelled = replace(obstacles, reason=np.where(in_range, reason, obstacles.reason))
    fitted = with_fitted_balls(skeleton, labelled, robot.layout, passes=40)
    before, after = (np.linalg.norm(each.balls - target.balls, axis=1) for each in (skeleton, fitted))
    # A ball that hardly ever is the lowest learns little.
    assert np.median(after) < 0.5 * np.median(before)
    assert after.mean() < before.mean()


def test_the_same_maps_make_the_same_balls_and_no_random_number_is_used_up(robot, skeleton, obstacles):
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    one = with_fitted_balls(skeleton, obstacles, robot.layout, passes=1)
    np.testing.assert_array_equal(torch.rand(3), expected)
    other = with_fitted_balls(skeleton, obstacles, robot.layout, passes=1)
    np.testing.assert_array_equal(one.balls, other.balls)
    np.testing.assert_array_equal(one.rises, other.rises)
    assert np.abs(one.balls - skeleton.balls).max() > 1e-4


def test_only_cells_in_range_count(robot, skeleton, obstacles):
    some = obstacles.take(slice(0, 4))
    trial, maps = CollisionTrial(robot.layout, skeleton), inputs(robot, some)
    counted = np.isin(some.reason, (Reason.FEASIBLE, Reason.TERRAIN_COLLISION))
    others = np.where(counted, some.reason, np.uint8(Reason.UNKNOWN))
    assert 0.1 < counted.mean() < 0.9
    assert trial.loss(maps, others).item() == trial.loss(maps, some.reason).item()
    labels = (some.reason == Reason.TERRAIN_COLLISION)[counted]
    logits = trial(maps).detach().numpy().reshape(counted.shape)[counted].astype(np.float64)
    surprise = np.log1p(np.exp(np.where(labels, -logits, logits)))
    assert trial.loss(maps, some.reason).item() == pytest.approx(surprise.mean(), rel=1e-5)


def test_fitted_numbers_travel_as_they_are(robot, skeleton, obstacles):
    fitted = with_fitted_balls(skeleton, obstacles, robot.layout, passes=1)
    back = LegSkeleton.from_dict(fitted.to_dict())
    np.testing.assert_array_equal(back.rises, fitted.rises)
    np.testing.assert_array_equal(back.balls, fitted.balls)
    # Of before balls were fitted.
    old = {key: value for key, value in skeleton.to_dict().items() if key != "rises"}
    assert LegSkeleton.from_dict(old).rises is None


def test_maps_that_no_leg_can_reach_teach_nothing(robot, skeleton, obstacles):
    """Also where an update gets nothing but such maps."""
    some = obstacles.take(slice(0, 9))
    reason = np.where(np.arange(9)[:, None, None] == 4, some.reason, np.uint8(Reason.KINEMATIC_RANGE))
    fitted = with_fitted_balls(skeleton, replace(some, reason=reason), robot.layout, passes=3)
    assert np.isfinite(fitted.balls).all() and np.isfinite(fitted.rises).all()
    assert np.abs(fitted.balls - skeleton.balls).max() > 0
