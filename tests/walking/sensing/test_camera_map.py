"""What the cameras make of a course that is known; and that nothing but the cameras tells of it."""

import numpy as np
import pytest

from footsel.footholds import BasePose
from footsel.mapping import D435
from footsel.selectors import make_selector
from footsel.terrain import ElevationMap
from footsel.walking.courses.registry import make_walk_course
from footsel.walking.ground import make_ground
from footsel.walking.sensing import CameraMap, camera_sight
from footsel.walking.sensing.camera_map import CAMERAS
from footsel.walking.sensing.own_bodies import OwnBodies

SMALL = D435(212, 120)


def exact():
    """A pose estimate without error."""
    return np.zeros((6, 6))


def camera_map(robot, simulation, seed=0, sensor=SMALL):
    return CameraMap(robot, simulation, exact, np.random.default_rng(seed), sensor)


def advance(source, simulation, stance, ground, way, step=0.04, speed=0.2):
    """Carry the robot along x at its height over the ground, estimated where it is."""
    base, joints = stance
    for x in np.arange(0, way + 1e-9, step):
        there = base.copy()
        there[0, 3] = x
        there[2, 3] += float(ground.sample([x, 0.0]))
        simulation.reset(there, joints)
        source.update(x / speed, there, joints)
    return there


def truth(elevation_map, ground):
    return ground.sample(np.stack(np.meshgrid(elevation_map.x(), elevation_map.y(), indexing="ij"), axis=-1))


@pytest.mark.parametrize("name", ["flat", "stairs", "blocks"])
def test_the_map_is_the_ground(robot, stance, simulate, name):
    course = make_walk_course(name, 1)
    simulation = simulate(course)
    source = camera_map(robot, simulation, sensor=D435())
    advance(source, simulation, stance, course.ground, 0.4)
    found = source.elevation_map()
    error = np.abs(found.elevation - truth(found, course.ground))
    known = np.isfinite(error)
    # Where the next steps go: within 1.2 m ahead of the base, as wide as the feet stand.
    x, y = np.meshgrid(found.x() - 0.4, found.y(), indexing="ij")
    ahead = (x > 0.1) & (x < 1.2) & (np.abs(y) < 0.35)
    assert known[ahead].mean() > (0.97 if name == "flat" else 0.7)
    assert np.median(error[ahead & known]) < 0.005
    assert np.percentile(error[ahead & known], 90) < 0.03
    assert np.isnan(source.variance()[~found.known]).all() and (source.variance()[found.known] > 0).all()


def test_gaps_between_stones_are_no_ground(robot, stance, simulate):
    course = make_walk_course("stones", 2)
    simulation = simulate(course)
    source = camera_map(robot, simulation, sensor=D435())
    end = advance(source, simulation, stance, course.ground, 0.3)
    found, heights = source.elevation_map(), truth(source.elevation_map(), course.ground)
    x, y = np.meshgrid(found.x() - end[0, 3], found.y(), indexing="ij")
    near = (x > 0.3) & (x < 1.1) & (np.abs(y) < 0.4)
    gap = near & (heights < -0.3)
    assert gap.sum() > 200
    assert (found.known[gap] & (found.elevation[gap] > -0.1)).mean() < 0.25
    assert found.known[near & (heights > -0.1)].mean() > 0.75


def test_the_start_leaves_the_robot_as_it_was_and_knows_where_the_first_steps_go(robot, simulate):
    simulation = simulate("flat")
    before = simulation.state()
    source = camera_map(robot, simulation)
    after = simulation.state()
    for name in ("base", "linear", "angular", "joints", "joint_velocities"):
        assert np.allclose(getattr(before, name), getattr(after, name), atol=1e-9), name
    found = source.elevation_map()
    x, y = np.meshgrid(found.x(), found.y(), indexing="ij")
    assert found.known[(np.abs(x) < 0.85) & (np.abs(y) < 0.35)].all()


def test_the_same_seed_gives_the_same_map(simulate):
    maps = []
    for seed in (5, 5, 6):
        make, drift = camera_sight(seed)
        simulation = simulate("blocks")
        source = make(simulation)
        state = drift.estimate(simulation.state())
        source.update(0.0, state.base, state.joints)
        maps.append(source.elevation_map().elevation)
    assert np.array_equal(maps[0], maps[1], equal_nan=True)
    assert not np.array_equal(maps[0], maps[2], equal_nan=True)


def test_images_are_taken_when_they_are_due(robot, stance, simulate, monkeypatch):
    simulation, taken = simulate("flat"), []
    source = camera_map(robot, simulation)
    read = D435.read
    monkeypatch.setattr(D435, "read", lambda self, depth, rng: taken.append(now) or read(self, depth, rng))
    ticks = range(1, 101)
    for tick in ticks:
        now = tick * 0.05
        source.update(now, *stance)
    front, rear = (each.period for each in CAMERAS)
    assert abs(len(taken) - 5 / front - 5 / rear) <= 2


def test_feet_that_stand_tell_how_high_the_ground_is_and_those_in_the_air_do_not(robot, stance, simulate):
    base, joints = stance
    covariance = np.zeros((6, 6))
    source = CameraMap(robot, simulate("flat"), covariance.copy, np.random.default_rng(0), SMALL)
    source.update(0.0, base, joints)
    covariance[2, 2] = 0.02**2
    lifted = base.copy()
    lifted[2, 3] += 0.02  # believed to be higher than it is
    source.update(0.01, lifted, joints)
    at = OwnBodies(robot).soles(lifted, joints)[:, :2]
    before = source.elevation_map().sample(at)
    source.feel(lifted, joints, np.zeros((4, 3)))
    assert np.array_equal(source.elevation_map().sample(at), before) and (np.abs(before) < 0.01).all()
    source.feel(lifted, joints, np.array([[0.0, 0.0, 100.0]] + 3 * [[0.0, 0.0, 1.0]]))
    assert np.allclose(source.elevation_map().sample(at), 0.02, atol=0.004)


@pytest.mark.parametrize("name", ["oracle", "cnn"])
def test_the_true_terrain_is_known_from_images_alone(robot, stance, simulate, name):
    """Other ground is put under the robot once the map is made: neither the map nor a choice on it changes."""
    course = make_walk_course("stairs", 0)
    simulation = simulate(course)
    source = camera_map(robot, simulation)
    end = advance(source, simulation, stance, course.ground, 0.2)
    selector = make_selector(name)
    pose = BasePose(end[0, 3], 0.0, end[2, 3], 0.0, 0.0, 0.0)
    map_before, before = source.elevation_map(), selector.select(source.elevation_map(), pose)

    simulation.client.removeBody(simulation.ground)
    other = ElevationMap(course.ground.elevation[::-1] - 0.3, course.ground.resolution, course.ground.position)
    simulation.ground = make_ground(simulation.client, other.elevation, other.resolution, other.position)
    course.ground.elevation[:] = other.elevation
    map_after, after = source.elevation_map(), selector.select(source.elevation_map(), pose)
    assert np.array_equal(map_before.elevation, map_after.elevation, equal_nan=True)
    assert {leg: each.to_dict() for leg, each in before.items()} == {leg: each.to_dict() for leg, each in after.items()}
    assert any(each.status == "ok" for each in before.values())

    # The next images tell of it.
    source.update(1e3, end, stance[1])
    assert not np.array_equal(map_after.elevation, source.elevation_map().elevation, equal_nan=True)
