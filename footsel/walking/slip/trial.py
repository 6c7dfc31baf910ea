"""One slip trial in PyBullet: a ball foot is set down, loaded and pushed sideways; how far does it slide?

The foot carries its share of the robot's weight, N, held from rolling as a leg holds it. After it has settled, the
trunk's motion pushes it sideways with 0.3 to 0.9 of mu N. Load and push act on the foot's share of the robot's mass, so
the mass cancels: both together are a gravity that tilts, the same for all feet of a world. Feet do not touch each
other, so one world tries many at once.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.terrain import ElevationMap
from footsel.walking.bullet import BulletWorld, pybullet
from footsel.walking.ground import make_ground
from footsel.walking.slip.touchdown import touchdown_heights

Array = NDArray[np.float64]

GRAVITY = 9.81
#: Bullet's own default. [s]
TIME_STEP = 1 / 240
#: Contacts converge well before this.
SOLVER_ITERATIONS = 50
#: The load alone, then the push, which grows from the lesser to the greater share of mu N. [s]
SETTLE_SECONDS, PUSH_SECONDS = 0.05, 0.3
PUSH_SHARES = (0.3, 0.9)
#: Directions of the push, evenly around.
DIRECTIONS = 8
#: A slide ends here, a foot radius away: the leg has lost its stand. [m]
SLIP_CAP = 0.03
#: A foot lands within this of the cell it is sent to. [m]
TOUCHDOWN_ERROR = 0.02
#: So hard to turn that it does not roll. An inertia of zero would say the same, but Bullet makes NaN of it. [kg m^2]
NO_ROLLING_INERTIA = 1e4
#: Unknown cells are a hole this deep, out of every foot's way. [m]
HOLE_DEPTH = 0.5

_FEET, _GROUND = 2, 1


class SlipWorld:
    """A course with `feet` feet on it.

    elevation_map: the course; its heights are the vertices of the ground, at the cell centres.
    foot_radius: in [m].
    """

    def __init__(self, elevation_map: ElevationMap, foot_radius: float, feet: int) -> None:
        heights = elevation_map.elevation.astype(np.float64)
        self._heights = np.where(np.isnan(heights), np.nanmin(heights) - HOLE_DEPTH, heights)
        self._resolution, self._position = elevation_map.resolution, elevation_map.position
        self._radius = foot_radius
        self._client = BulletWorld()
        self._client.setPhysicsEngineParameter(
            fixedTimeStep=TIME_STEP,
            numSolverIterations=SOLVER_ITERATIONS,
            enableConeFriction=1,
            deterministicOverlappingPairs=1,
        )
        self._ground = self._make_ground()
        self._feet = [self._make_foot() for _ in range(feet)]

    def close(self) -> None:
        """End the simulation."""
        self._client.disconnect()

    def slip(self, xy: Array, friction: float, direction: float) -> Array:
        """(n,) how far feet set down at xy (n, 2) slide when pushed towards `direction`, at most SLIP_CAP, in [m].

        friction: mu between foot and ground. direction: in [rad] from the x axis. n may be at most `feet`.
        """
        client, feet = self._client, self._feet[: len(xy)]
        landing = touchdown_heights(self._heights, self._resolution, self._radius, xy - self._position)
        # The friction of a contact is the product of both bodies'; the feet have 1.
        client.changeDynamics(self._ground, -1, lateralFriction=friction)
        for foot, (x, y), z in zip(feet, xy.tolist(), landing.tolist(), strict=True):
            client.resetBasePositionAndOrientation(foot, (x, y, z), (0, 0, 0, 1))
            client.resetBaseVelocity(foot, (0, 0, 0), (0, 0, 0))
        start = self._positions(feet)
        client.setGravity(0, 0, -GRAVITY)
        for _ in range(round(SETTLE_SECONDS / TIME_STEP)):
            client.stepSimulation()
        for share in np.linspace(*PUSH_SHARES, round(PUSH_SECONDS / TIME_STEP)).tolist():
            push = share * friction * GRAVITY
            client.setGravity(push * np.cos(direction), push * np.sin(direction), -GRAVITY)
            client.stepSimulation()
        return np.asarray(np.minimum(np.linalg.norm(self._positions(feet) - start, axis=1), SLIP_CAP))

    def _positions(self, feet: list[int]) -> Array:
        return np.array([self._client.getBasePositionAndOrientation(foot)[0] for foot in feet])

    def _make_ground(self) -> int:
        ground = make_ground(self._client, self._heights, self._resolution, self._position)
        self._client.setCollisionFilterGroupMask(ground, -1, _GROUND, _FEET)
        return ground

    def _make_foot(self) -> int:
        shape: Any = self._client.createCollisionShape(pybullet.GEOM_SPHERE, radius=self._radius)
        foot = self._client.createMultiBody(1.0, shape, basePosition=[0, 0, 10.0])
        self._client.changeDynamics(
            foot,
            -1,
            lateralFriction=1.0,
            rollingFriction=0.0,
            spinningFriction=0.0,
            restitution=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            localInertiaDiagonal=[NO_ROLLING_INERTIA] * 3,
        )
        self._client.setCollisionFilterGroupMask(foot, -1, _FEET, _GROUND)
        return int(foot)


@contextmanager
def slip_world(elevation_map: ElevationMap, foot_radius: float, feet: int) -> Iterator[SlipWorld]:
    """A SlipWorld that ends with the block."""
    world = SlipWorld(elevation_map, foot_radius, feet)
    try:
        yield world
    finally:
        world.close()


def slip_trials(world: SlipWorld, xy: Array, friction: float, rng: np.random.Generator) -> Array:
    """(n, DIRECTIONS) slip of feet sent to xy (n, 2), each push with a touchdown error of its own, in [m]."""
    slips = []
    for number in range(DIRECTIONS):
        turn, distance = rng.uniform(0, 2 * np.pi, len(xy)), TOUCHDOWN_ERROR * np.sqrt(rng.uniform(0, 1, len(xy)))
        error = distance[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
        slips.append(world.slip(xy + error, friction, 2 * np.pi * number / DIRECTIONS))
    return np.column_stack(slips)
