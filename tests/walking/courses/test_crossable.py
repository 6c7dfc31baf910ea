"""Courses can be crossed: wherever the base is on its way, each leg has a foothold by the oracle's judgement."""

import numpy as np
import pytest

from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.selectors import make_selector
from footsel.walking.courses import make_walk_course

HEIGHT = 0.44
FEET = {leg: np.array([0.36 if leg[1] == "F" else -0.36, 0.246 if leg[0] == "L" else -0.246]) for leg in LEGS}


def pose_over(course, x):
    """A base over the plane of the ground that feet would find, tilted by most of that plane's slope."""
    around = np.stack(np.meshgrid(*[np.linspace(-0.1, 0.1, 9)] * 2), -1)
    ground = [np.nanpercentile(course.ground.sample(FEET[leg] + np.array([x, 0]) + around), 75) for leg in LEGS]
    plane = np.linalg.lstsq(np.array([[*FEET[leg], 1] for leg in LEGS]), np.array(ground), rcond=None)[0]
    return BasePose(x, 0, plane[2] + HEIGHT, 0.8 * np.arctan(plane[1]), -0.8 * np.arctan(plane[0]), 0)


@pytest.mark.parametrize("name", ["stairs", "stairs17", "slopes", "rough", "blocks", "rubble", "stones", "gaps"])
def test_every_leg_has_a_foothold_along_the_way(name):
    oracle = make_selector("oracle")
    course = make_walk_course(name, 21)
    answers = []
    for x in np.arange(0.1, course.goal[0], 0.2):
        nominal = {leg: FEET[leg] + np.array([x + 0.16, 0]) for leg in LEGS}
        footholds = oracle.select(course.known, pose_over(course, x), nominal=nominal)
        answers += [footholds[leg].status == "ok" for leg in LEGS]
    assert np.mean(answers) > 0.95
