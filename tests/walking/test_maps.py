"""What a walk knows of its ground, and of itself."""

import numpy as np
import pytest

from footsel.errors import UnknownNameError
from footsel.robot import load_robot
from footsel.walking.courses import make_walk_course
from footsel.walking.map_source import GivenMap
from footsel.walking.maps import DriftingState, make_senses
from footsel.walking.sensing import CameraMap, PoseDrift
from footsel.walking.simulation import Simulation
from footsel.walking.state import GroundTruth, RobotState


@pytest.fixture(scope="module")
def course():
    return make_walk_course("blocks", 0)


def state_at(time):
    base = np.eye(4)
    c, s = np.cos(0.3), np.sin(0.3)
    base[:2, :2] = [[c, -s], [s, c]]
    base[:3, 3] = [time, 0.1, 0.5]
    return RobotState(
        time, base, np.array([0.5, 0.1, 0]), np.array([0, 0.2, 0.1]), np.zeros(12), np.ones(12), np.eye(4, 3) * 100
    )


def test_exact_is_the_known_map_and_the_truth(course):
    senses = make_senses("exact", course, load_robot(), 0)
    assert isinstance(senses.map_source, GivenMap) and senses.map_source.elevation_map() is course.known
    state = state_at(1.0)
    assert isinstance(senses.estimator, GroundTruth) and senses.estimator.estimate(state) is state


def test_noisy_is_another_map_for_another_seed_and_the_same_for_the_same(course):
    maps = [make_senses("noisy", course, load_robot(), seed).map_source.elevation_map() for seed in (3, 3, 4)]
    np.testing.assert_array_equal(maps[0].elevation, maps[1].elevation)
    assert not np.array_equal(maps[0].elevation, maps[2].elevation, equal_nan=True)
    error = maps[0].elevation - course.known.elevation
    assert 0.002 < np.nanmedian(np.abs(error)) < 0.03
    assert np.isnan(error).mean() > 0.01


def test_camera_makes_its_map_in_the_simulation(course):
    robot = load_robot()
    senses = make_senses("camera", course, robot, 0)
    base = np.eye(4)
    base[2, 3] = 0.48
    joints = np.array([robot.description.stance[leg] for leg in ("LF", "RF", "LH", "RH")]).ravel()
    with Simulation(course.ground, robot, base, joints) as simulation:
        source = senses.map_source(simulation)
        assert isinstance(source, CameraMap)
        state = senses.estimator.estimate(simulation.state())
        source.update(0.0, state.base, state.joints)
        known = source.elevation_map()
        x, y = np.meshgrid(np.arange(0.9, 1.5, 0.04), np.arange(-0.3, 0.3, 0.04), indexing="ij")
        seen = known.sample(np.stack([x, y], axis=-1))
    assert np.isfinite(seen).mean() > 0.5
    assert np.nanmedian(np.abs(seen - course.ground.sample(np.stack([x, y], axis=-1)))) < 0.03


def test_a_drifting_robot_feels_the_same_in_its_own_frame():
    """What is measured in the body does not depend on where the robot believes to be."""
    estimator = DriftingState(PoseDrift(np.random.default_rng(0)))
    for time in np.arange(0, 3, 0.1):
        truth = state_at(float(time))
        believed = estimator.estimate(truth)
        for name in ("linear", "angular"):
            in_body = getattr(believed, name) @ believed.base[:3, :3]
            np.testing.assert_allclose(in_body, getattr(truth, name) @ truth.base[:3, :3], atol=1e-12)
        np.testing.assert_allclose(
            believed.foot_forces @ believed.base[:3, :3], truth.foot_forces @ truth.base[:3, :3], atol=1e-9
        )
        assert believed.time == truth.time and believed.joints is truth.joints
    assert 1e-4 < np.linalg.norm(believed.base[:3, 3] - truth.base[:3, 3]) < 0.1


def test_another_name_is_told(course):
    with pytest.raises(UnknownNameError, match=r"map 'radar'.*exact, noisy, camera"):
        make_senses("radar", course, load_robot(), 0)
