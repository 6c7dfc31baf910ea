"""What a walk knows of its ground, by the name that a user types, and how well it knows where it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from footsel.errors import UnknownNameError
from footsel.walking.course import WalkCourse
from footsel.walking.map_source import GivenMap, MapSource
from footsel.walking.state import GroundTruth, RobotState, StateEstimator

if TYPE_CHECKING:
    from footsel.robot.robot import Robot
    from footsel.walking.sensing import PoseDrift
    from footsel.walking.simulation.simulation import Simulation

#: exact: the known map itself. noisy: as one depth camera's readings leave it, with holes and drift, all known at once.
#: camera: made on the way by depth cameras, placed by a pose that drifts.
MAPS = ("exact", "noisy", "camera")
#: Keep random numbers of the sensors apart from those of the course and of the start.
_NOISE, _DRIFT = 1, 2


@dataclass(frozen=True, eq=False)
class Senses:
    """map_source: what `walk` takes as such. estimator: of the robot's state."""

    map_source: MapSource | Callable[[Simulation], MapSource]
    estimator: StateEstimator


class DriftingState(StateEstimator):
    """The truth as seen by a robot that is wrong about its pose by a drift, and so about directions."""

    def __init__(self, drift: PoseDrift) -> None:
        self._drift = drift

    def estimate(self, truth: RobotState) -> RobotState:
        base = self._drift.estimate(truth.time, truth.base)
        turn = base[:3, :3] @ truth.base[:3, :3].T
        return RobotState(
            time=truth.time,
            base=base,
            linear=turn @ truth.linear,
            angular=turn @ truth.angular,
            joints=truth.joints,
            joint_velocities=truth.joint_velocities,
            foot_forces=truth.foot_forces @ turn.T,
        )


def make_senses(name: str, course: WalkCourse, robot: Robot, seed: int) -> Senses:
    """The senses of a name in MAPS; the same for the same seed. Only `exact` and `noisy` look at the course.

    Raises UnknownNameError for another name.
    """
    if name not in MAPS:
        raise UnknownNameError("map", name, MAPS)
    if name == "exact":
        return Senses(GivenMap(course.known), GroundTruth())
    from footsel.walking.sensing import CameraMap, PoseDrift, noisy_map

    noise = np.random.default_rng([seed, _NOISE])
    if name == "noisy":
        return Senses(GivenMap(noisy_map(course.known, noise)), GroundTruth())
    drift = PoseDrift(np.random.default_rng([seed, _DRIFT]))

    def camera_map(simulation: Simulation) -> MapSource:
        return CameraMap(robot, simulation.client, lambda: simulation.state().base, lambda: drift.covariance, rng=noise)

    return Senses(camera_map, DriftingState(drift))
