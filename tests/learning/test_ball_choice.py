"""The balls that a network gets: the most telling ones, whatever their order, and always the same."""

from dataclasses import replace

import numpy as np
import pytest

from footsel.footholds import Reason
from footsel.learning.ball_choice import _errors, _seen, with_best_balls
from footsel.learning.skeleton import LegSkeleton


def test_the_first_ball_is_the_best_and_each_further_one_helps(robot, obstacles):
    skeleton = LegSkeleton.of(robot, "LF")
    clearance, collides = _seen(skeleton, obstacles, robot.layout)
    assert 0.1 < collides.mean() < 0.6
    alone = [_errors(clearance[:, ball], collides) for ball in range(len(skeleton.radius))]
    one = with_best_balls(skeleton, obstacles, robot.layout, 1)
    np.testing.assert_array_equal(one.balls[0], skeleton.balls[int(np.argmin(alone))])

    def errors(count):
        chosen = with_best_balls(skeleton, obstacles, robot.layout, count)
        assert len(chosen.radius) == len(chosen.link) == len(chosen.balls) == count
        found, _ = _seen(chosen, obstacles, robot.layout)
        return _errors(found.min(axis=1), collides)

    assert errors(1) > errors(3) > errors(6)
    assert errors(6) < 1.2 * _errors(clearance.min(axis=1), collides)


def test_the_order_of_the_balls_decides_nothing(robot, obstacles):
    skeleton = LegSkeleton.of(robot, "LF")
    turned = replace(
        skeleton, link=skeleton.link[::-1], balls=skeleton.balls[::-1].copy(), radius=skeleton.radius[::-1]
    )
    one, other = (with_best_balls(each, obstacles, robot.layout, 4) for each in (skeleton, turned))
    np.testing.assert_array_equal(one.balls, other.balls[::-1])


def test_what_is_seen_anyway_needs_no_ball(robot, obstacles):
    """The ball at the hip is among the five that tell most, but not for a network that sees the hip itself."""
    skeleton = LegSkeleton.of(robot, "LF")

    def at_hip(count, hip):
        chosen = with_best_balls(skeleton, obstacles, robot.layout, count, hip)
        return ((chosen.link == 0) & (np.hypot(*chosen.balls[:, [0, 2]].T) < 0.01)).any()

    assert at_hip(5, hip=False)
    assert not at_hip(4, hip=True)


def test_fitted_rises_go_with_the_balls_that_are_left(robot, obstacles):
    skeleton = LegSkeleton.of(robot, "LF")
    radii = np.unique(skeleton.radius)
    fitted = replace(skeleton, rises=np.tile(radii[:, None], 3))
    fewer = with_best_balls(fitted, obstacles, robot.layout, 2)
    assert fewer.rises is not None
    np.testing.assert_array_equal(fewer.rises[:, 0], np.unique(fewer.radius))


@pytest.mark.parametrize("count", [0, 99])
def test_all_are_kept_if_there_is_no_limit_or_a_high_one(robot, obstacles, count):
    skeleton = LegSkeleton.of(robot, "LF")
    assert with_best_balls(skeleton, obstacles, robot.layout, count) is skeleton


def test_errors_are_those_of_the_best_threshold():
    rng = np.random.default_rng(0)
    for _ in range(50):
        least, collides = rng.normal(size=40).astype(np.float32), rng.random(40) < 0.3
        thresholds = [-np.inf, *(least + 1e-6)]
        assert _errors(least, collides) == min(int(((least < t) != collides).sum()) for t in thresholds)
    assert _errors(np.zeros(0, dtype=np.float32), np.zeros(0, dtype=bool)) == 0


def test_maps_without_collisions_choose_too(robot, obstacles):
    tame = replace(
        obstacles, reason=np.where(obstacles.reason == Reason.TERRAIN_COLLISION, Reason.FEASIBLE, obstacles.reason)
    )
    assert len(with_best_balls(LegSkeleton.of(robot, "LF"), tame, robot.layout, 3).radius) == 3


def test_what_is_looked_at_lies_all_over_the_maps(obstacles):
    assert obstacles.spread(99).course.tolist() == obstacles.course.tolist()
    some = obstacles.spread(4)
    for index, heights in zip((0, 19, 39, 59), some.heights_tenth_mm, strict=True):
        np.testing.assert_array_equal(heights, obstacles.heights_tenth_mm[index])
