"""A robot at the start of a course."""

from collections.abc import Callable

import numpy as np
import pytest

from footsel.legs import LEGS
from footsel.robot import Robot, load_robot
from footsel.walking.courses.registry import make_walk_course
from footsel.walking.simulation import Simulation


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot()


@pytest.fixture(scope="session")
def stance(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Base placement and joint angles of the nominal stance over the origin."""
    base = np.eye(4)
    base[2, 3] = -robot.layout.nominal_feet["LF"][2]
    return base, np.concatenate([robot.description.stance[leg] for leg in LEGS])


@pytest.fixture
def simulate(robot: Robot, stance) -> Callable[..., Simulation]:
    """simulate(course or name): the robot on it."""
    running = []

    def start(course="stairs", seed=0):
        course = make_walk_course(course, seed) if isinstance(course, str) else course
        running.append(Simulation(course.ground, robot, *stance))
        return running[-1]

    yield start
    for simulation in running:
        simulation.close()
