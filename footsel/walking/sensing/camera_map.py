"""The walker's map from what its depth cameras see: it holds no terrain, only a view of the world."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.mapping import D435, ElevationMapping, MappingConfig
from footsel.robot.robot import Robot
from footsel.terrain import ElevationMap
from footsel.walking.map_source import MapSource
from footsel.walking.sensing.mounts import FRONT, REAR
from footsel.walking.sensing.own_bodies import OwnBodies
from footsel.walking.sensing.renderer import true_depth
from footsel.walking.simulation import Simulation

Array = NDArray[np.float64]

#: The robot has come to its start over even ground: from so far behind, with images so far apart, so fast. [m], [m/s]
APPROACH, APPROACH_STEP, APPROACH_SPEED = 0.6, 0.1, 0.05
#: Where it came from, the ground that it stood on went on for this far around its feet, in [m], known to 1 cm.
APRON, APRON_VARIANCE = 0.4, 0.01**2
#: A foot that is pushed up so hard stands on the ground. Its sole is as high as the ground, but for how uneven that is
#: and how well the legs are known: assumptions. [N], [m^2]
STANDING_FORCE, SOLE_VARIANCE = 20.0, 0.005**2


@dataclass(frozen=True, eq=False)
class BodyCamera:
    """mount: (4, 4) placement of the camera's frame in B. period: least time between two images, in [s]."""

    mount: Array
    period: float


CAMERAS = (BodyCamera(FRONT, 0.2), BodyCamera(REAR, 1.0))


class CameraMap(MapSource):
    """A robot-centric map of 6x6 m fused from a D435 at the front and one at the rear.

    simulation: gives the images, from where the cameras truly are; the map is placed by the estimate.
    covariance: (6, 6) of the pose estimate, as of the time of an update.
    sensor, cameras: what the cameras are and where they sit. rng: of the sensor's noise.

    No camera sees the ground under the robot and just ahead of its feet. So the robot has walked up to its start: the
    map is made along the last 60 cm before it. Where that began, the robot was told that it stood on even ground: the
    map starts as the plane through its soles, known to 1 cm, as ANYbotics' elevation mapping does it.
    On the way, the feet that stand say how far the map has drifted since the ground around them was seen.
    """

    learns = True

    def __init__(
        self,
        robot: Robot,
        simulation: Simulation,
        covariance: Callable[[], Array],
        rng: np.random.Generator,
        sensor: D435 | None = None,
        cameras: tuple[BodyCamera, ...] = CAMERAS,
        config: MappingConfig | None = None,
    ) -> None:
        self._own_bodies = OwnBodies(robot)
        self._simulation, self._covariance = simulation, covariance
        self._rng, self._sensor, self._cameras = rng, sensor or D435(), cameras
        self._mapping = ElevationMapping(config)
        self._due = [-np.inf] * len(cameras)
        self._walk_up()

    def update(self, time: float, base: Array, joints: Array) -> None:
        """Follow the robot and take the images that are due."""
        self._mapping.move(base, self._covariance())
        bodies = self._own_bodies.capsules(base, joints)
        camera, true_base = self._sensor.camera, self._simulation.state().base
        for number, each in enumerate(self._cameras):
            if time >= self._due[number]:
                # Times are sums of small steps: a hair's breadth early is in time.
                self._due[number] = time + each.period - 1e-6
                depth = true_depth(self._simulation.client, camera, true_base @ each.mount)
                self._mapping.integrate(self._sensor.read(depth, self._rng), camera, base @ each.mount, bodies)

    def feel(self, base: Array, joints: Array, foot_forces: Array) -> None:
        """The ground is where feet stand on it: no camera looks there, and the pose has drifted since one did."""
        standing = foot_forces[:, 2] > STANDING_FORCE
        self._mapping.touch(self._own_bodies.soles(base, joints)[standing], SOLE_VARIANCE)

    def elevation_map(self) -> ElevationMap:
        """As fused so far; what no camera has seen is NaN."""
        return self._mapping.elevation_map()

    def variance(self) -> NDArray[np.float32]:
        """(nx, ny) of the heights of `elevation_map`, NaN where unknown, in [m^2]."""
        return self._mapping.variance

    def _walk_up(self) -> None:
        """Look from where the robot came from, then put it back as it was."""
        start = self._simulation.state()
        ahead = start.base[:3, 0] * [1, 1, 0]
        ahead /= np.linalg.norm(ahead)
        ways = -np.arange(APPROACH, 0, -APPROACH_STEP)
        for way in ways.tolist():
            base = start.base.copy()
            base[:3, 3] += way * ahead
            self._simulation.reset(base, start.joints)
            if way == ways[0]:
                self._mapping.move(base)
                self._mapping.lay_plane(self._own_bodies.soles(base, start.joints), APRON, APRON_VARIANCE)
            self.update(start.time + way / APPROACH_SPEED, base, start.joints)
        velocity = np.concatenate([start.linear, start.angular, start.joint_velocities])
        self._simulation.reset(start.base, start.joints, velocity)
