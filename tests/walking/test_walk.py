"""Whole walks in physics, short: on every terrain, over stones one by one, and on level ground as anyone can."""

import pytest

from footsel.selectors import make_selector
from footsel.walking.courses import WALK_COURSES, make_walk_course
from footsel.walking.map_source import GivenMap
from footsel.walking.walk import walk


@pytest.mark.parametrize("selector", ["nominal", "cnn"])
def test_level_ground_is_crossed(selector):
    course = make_walk_course("flat", 0)
    result = walk(course, make_selector(selector), GivenMap(course.known), 0, "exact", time_limit_s=12.0)
    assert result.reason == "goal not reached within 12 s"
    assert result.distance_m > 0.5 and result.steps >= 8
    assert result.slip_max_mm < 30 and result.tracking_error_mm < 20 and result.min_stability_margin_m > 0.01


@pytest.mark.parametrize("terrain", [name for name in WALK_COURSES if name != "flat"])
def test_a_walk_begins_on_every_terrain(terrain):
    """The first half minute, onto the obstacle, with footholds by the network."""
    course = make_walk_course(terrain, 0)
    result = walk(course, make_selector("cnn"), GivenMap(course.known), 0, "exact", time_limit_s=30.0)
    assert result.reason == "goal not reached within 30 s"
    assert result.distance_m > 1.0 and result.slip_max_mm < 40 and result.tracking_error_mm < 20
    assert result.shank_impacts == 0 and result.hind_shank_contact_s == 0


def test_stones_are_stepped_on_one_by_one():
    """The first stones of the stream, chosen by the oracle."""
    course = make_walk_course("stones", 0)
    result = walk(course, make_selector("oracle"), GivenMap(course.known), 0, "exact", time_limit_s=30.0)
    assert result.reason == "goal not reached within 30 s"
    assert result.distance_m > 1.2 and result.slip_max_mm < 40 and result.shank_impacts == 0
