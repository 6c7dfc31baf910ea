"""What a walk knows of its ground, and of itself."""

import numpy as np
import pytest

from footsel.errors import UnknownNameError
from footsel.robot import load_robot
from footsel.walking.courses import make_walk_course
from footsel.walking.map_source import GivenMap
from footsel.walking.maps import make_senses
from footsel.walking.sensing import CameraMap, PoseDrift
from footsel.walking.simulation import Simulation
from footsel.walking.state import GroundTruth


@pytest.fixture(scope="module")
def course():
    return make_walk_course("blocks", 0)


def test_exact_is_the_known_map_and_the_truth(course):
    senses = make_senses("exact", course, "anymal_b", 0)
    assert isinstance(senses.map_source, GivenMap) and senses.map_source.elevation_map() is course.known
    assert isinstance(senses.estimator, GroundTruth)


def test_noisy_is_another_map_for_another_seed_and_the_same_for_the_same(course):
    maps = [make_senses("noisy", course, "anymal_b", seed).map_source.elevation_map() for seed in (3, 3, 4)]
    np.testing.assert_array_equal(maps[0].elevation, maps[1].elevation)
    assert not np.array_equal(maps[0].elevation, maps[2].elevation, equal_nan=True)
    error = maps[0].elevation - course.known.elevation
    assert 0.0005 < np.nanmedian(np.abs(error)) < 0.03
    assert np.isnan(error).mean() > 0.01


def test_camera_makes_its_map_in_the_simulation(course):
    robot = load_robot()
    senses = make_senses("camera", course, "anymal_b", 0)
    base = np.eye(4)
    base[2, 3] = 0.48
    joints = np.array([robot.description.stance[leg] for leg in ("LF", "RF", "LH", "RH")]).ravel()
    with Simulation(course.ground, robot, base, joints) as simulation:
        source = senses.map_source(simulation)
        assert isinstance(source, CameraMap) and isinstance(senses.estimator, PoseDrift)
        state = senses.estimator.estimate(simulation.state())
        source.update(0.0, state.base, state.joints)
        known = source.elevation_map()
        x, y = np.meshgrid(np.arange(0.9, 1.5, 0.04), np.arange(-0.3, 0.3, 0.04), indexing="ij")
        seen = known.sample(np.stack([x, y], axis=-1))
    assert np.isfinite(seen).mean() > 0.5
    assert np.nanmedian(np.abs(seen - course.ground.sample(np.stack([x, y], axis=-1)))) < 0.03


def test_another_name_is_told(course):
    with pytest.raises(UnknownNameError, match=r"map 'radar'.*exact, noisy, camera"):
        make_senses("radar", course, "anymal_b", 0)
