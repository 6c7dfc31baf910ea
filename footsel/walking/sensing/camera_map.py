"""The walker's map from what its depth cameras see: it holds no terrain, only a view of the world."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.mapping import D435, ElevationMapping, MappingConfig
from footsel.robot.robot import Robot
from footsel.terrain import ElevationMap
from footsel.walking.bullet import BulletWorld
from footsel.walking.map_source import MapSource
from footsel.walking.sensing.mounts import FRONT, REAR
from footsel.walking.sensing.own_bodies import OwnBodies
from footsel.walking.sensing.renderer import true_depth

Array = NDArray[np.float64]

#: The ground that the feet stand on at the start goes on for this far around them, in [m], known to 1 cm.
APRON, APRON_VARIANCE = 0.4, 0.01**2


@dataclass(frozen=True, eq=False)
class BodyCamera:
    """mount: (4, 4) placement of the camera's frame in B. period: least time between two images, in [s]."""

    mount: Array
    period: float


CAMERAS = (BodyCamera(FRONT, 0.1), BodyCamera(REAR, 0.5))


class CameraMap(MapSource):
    """A robot-centric map of 6x6 m fused from a D435 at the front and one at the rear.

    world, true_base: give the images, from where the cameras truly are; the map is placed by the estimate.
    covariance: (6, 6) of the pose estimate, as of the time of the update.
    sensor, cameras: what the cameras are and where they sit. rng: of the sensor's noise.

    Under the robot no camera looks. It is told that it begins on even ground: the map starts as the plane through its
    soles, 40 cm beyond them and with a standard deviation of 1 cm, as ANYbotics' elevation mapping does it.
    """

    def __init__(
        self,
        robot: Robot,
        world: BulletWorld,
        true_base: Callable[[], Array],
        covariance: Callable[[], Array],
        rng: np.random.Generator,
        sensor: D435 | None = None,
        cameras: tuple[BodyCamera, ...] = CAMERAS,
        config: MappingConfig | None = None,
    ) -> None:
        self._own_bodies = OwnBodies(robot)
        self._world, self._true_base, self._covariance = world, true_base, covariance
        self._rng, self._sensor, self._cameras = rng, sensor or D435(), cameras
        self._mapping = ElevationMapping(config)
        self._due = [-np.inf] * len(cameras)
        self._begun = False

    def update(self, time: float, base: Array, joints: Array) -> None:
        """Follow the robot and take the images that are due."""
        self._mapping.move(base, self._covariance())
        if not self._begun:
            self._begun = True
            self._mapping.lay_plane(self._own_bodies.soles(base, joints), APRON, APRON_VARIANCE)
        bodies = self._own_bodies.capsules(base, joints)
        camera, true_base = self._sensor.camera, self._true_base()
        for number, each in enumerate(self._cameras):
            if time >= self._due[number]:
                # Times are sums of small steps: a hair's breadth early is in time.
                self._due[number] = time + each.period - 1e-6
                depth = true_depth(self._world, camera, true_base @ each.mount)
                self._mapping.integrate(self._sensor.read(depth, self._rng), camera, base @ each.mount, bodies)

    def elevation_map(self) -> ElevationMap:
        """As fused so far; what no camera has seen is NaN."""
        return self._mapping.elevation_map()

    def variance(self) -> NDArray[np.float32]:
        """(nx, ny) of the heights of `elevation_map`, NaN where unknown, in [m^2]."""
        return self._mapping.variance
