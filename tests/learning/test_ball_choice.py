"""The balls that a network gets: the most telling ones, whatever their order, and always the same."""

from dataclasses import replace

import numpy as np
import pytest

from footsel.dataset.config import DatasetConfig
from footsel.dataset.labelling import make_samples
from footsel.footholds import Reason
from footsel.learning.ball_choice import _errors, _seen, with_best_balls
from footsel.learning.skeleton import LegSkeleton
from footsel.robot import load_robot


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal_b")


@pytest.fixture(scope="module")
def samples():
    families = ("pillars", "stones", "rubble")
    config = DatasetConfig("anymal_b", ("front",), 60, 3, "footsel", families, maps_per_shard=60)
    return make_samples(config, "front", 0)


def test_the_first_ball_is_the_best_and_each_further_one_helps(robot, samples):
    skeleton = LegSkeleton.of(robot, "LF")
    clearance, collides = _seen(skeleton, samples, robot.layout)
    assert 0.1 < collides.mean() < 0.6
    alone = [_errors(clearance[:, ball], collides) for ball in range(len(skeleton.radius))]
    one = with_best_balls(skeleton, samples, robot.layout, 1)
    np.testing.assert_array_equal(one.balls[0], skeleton.balls[int(np.argmin(alone))])

    def errors(count):
        chosen = with_best_balls(skeleton, samples, robot.layout, count)
        assert len(chosen.radius) == len(chosen.link) == len(chosen.balls) == count
        found, _ = _seen(chosen, samples, robot.layout)
        return _errors(found.min(axis=1), collides)

    assert errors(1) > errors(3) > errors(6)
    assert errors(6) < 1.2 * _errors(clearance.min(axis=1), collides)


def test_the_order_of_the_balls_decides_nothing(robot, samples):
    skeleton = LegSkeleton.of(robot, "LF")
    turned = replace(
        skeleton, link=skeleton.link[::-1], balls=skeleton.balls[::-1].copy(), radius=skeleton.radius[::-1]
    )
    one, other = (with_best_balls(each, samples, robot.layout, 4) for each in (skeleton, turned))
    np.testing.assert_array_equal(one.balls, other.balls[::-1])


@pytest.mark.parametrize("count", [0, 99])
def test_all_are_kept_if_there_is_no_limit_or_a_high_one(robot, samples, count):
    skeleton = LegSkeleton.of(robot, "LF")
    assert with_best_balls(skeleton, samples, robot.layout, count) is skeleton


def test_errors_are_those_of_the_best_threshold():
    rng = np.random.default_rng(0)
    for _ in range(50):
        least, collides = rng.normal(size=40).astype(np.float32), rng.random(40) < 0.3
        thresholds = [-np.inf, *(least + 1e-6)]
        assert _errors(least, collides) == min(int(((least < t) != collides).sum()) for t in thresholds)
    assert _errors(np.zeros(0, dtype=np.float32), np.zeros(0, dtype=bool)) == 0


def test_maps_without_collisions_choose_too(robot, samples):
    tame = replace(
        samples, reason=np.where(samples.reason == Reason.TERRAIN_COLLISION, Reason.FEASIBLE, samples.reason)
    )
    assert len(with_best_balls(LegSkeleton.of(robot, "LF"), tame, robot.layout, 3).radius) == 3
