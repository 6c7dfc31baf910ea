"""What a walk knows of its ground, by the name that a user types, and how well it knows where it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from footsel.errors import UnknownNameError
from footsel.walking.course import WalkCourse
from footsel.walking.map_source import GivenMap, MapSource
from footsel.walking.state import GroundTruth, StateEstimator

if TYPE_CHECKING:
    from footsel.walking.simulation.simulation import Simulation

#: exact: the known map itself. noisy: as one depth camera's readings leave it, with holes and drift, all known at once.
#: camera: made on the way by depth cameras, placed by a pose that drifts, and held to the feet that stand.
MAPS = ("exact", "noisy", "camera")
#: Keeps the sensor's random numbers apart from those of the course and of the start.
NOISE_STREAM = 1


@dataclass(frozen=True, eq=False)
class Senses:
    """map_source: what `walk` takes as such. estimator: of the robot's state."""

    map_source: MapSource | Callable[[Simulation], MapSource]
    estimator: StateEstimator


def make_senses(name: str, course: WalkCourse, robot: str, seed: int) -> Senses:
    """The senses of a name in MAPS; the same for the same seed. Only `exact` and `noisy` look at the course.

    Raises UnknownNameError for another name.
    """
    if name not in MAPS:
        raise UnknownNameError("map", name, MAPS)
    if name == "exact":
        return Senses(GivenMap(course.known), GroundTruth())
    from footsel.walking.sensing import camera_sight, noisy_map

    if name == "noisy":
        noise = np.random.default_rng([seed, NOISE_STREAM])
        return Senses(GivenMap(noisy_map(course.known, noise)), GroundTruth())
    return Senses(*camera_sight(seed, robot))
