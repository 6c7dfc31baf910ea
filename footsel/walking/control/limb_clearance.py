"""How far thighs and shanks stay clear of the ground as the map knows it, and how that changes as the base moves.

Every collision body is covered by balls. A ball grown by the wanted distance is held against the ground under it: as
far as its surface is above every cell there, that far is the limb clear. A ball beside a step feels the step's edge, so
the answer is about distance and not only about height.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from footsel.compiled import compiled
from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.oracle.swing_bodies import SwingBodies
from footsel.robot.leg_kinematics import link_frames, solve
from footsel.robot.medial_axis import medial_axis
from footsel.robot.robot import Robot
from footsel.terrain import ElevationMap
from footsel.walking.simulation.contacts import LOWER_SHANK

Array = NDArray[np.float64]
#: Hips, parameters and axes as in SwingBodies, balls of all legs, and where each leg's balls begin and end.
Legs = tuple[Array, Array, Array, Array, NDArray[np.int64]]
#: Heights, side of a cell and (2,) world xy of the centre of cell (0, 0), in [m].
Ground = tuple[NDArray[np.float32], float, Array]

#: Balls along a body are at most this far apart. [m]
SPACING = 0.04
#: How far limbs should be from the ground. [m]
DISTANCE = 0.03
#: A ball beside an edge is not pushed aside harder than at this slope of its surface.
STEEPEST = 2.0
#: Change of a pose from which rates are found. [m], [rad]
SHIFT = 1e-4
#: Thigh, shank.
LIMBS = 2


@dataclass(frozen=True, eq=False)
class Clearance:
    """least: (4, LIMBS) how far thigh and shank of each leg, by LEGS, are clear of the ground beyond DISTANCE, inf over
    unknown ground, negative if they are nearer, in [m]. rates: (4, LIMBS, 5) of these with the base's x, y, z, roll,
    pitch while the feet stay, in [m/m] and [m/rad].
    """

    least: Array
    rates: Array

    def worse(self, other: "Clearance") -> "Clearance":
        """Limb by limb the one that is nearer to the ground."""
        nearer = other.least < self.least
        rates = np.where(nearer[..., None], other.rates, self.rates)
        return Clearance(np.minimum(self.least, other.least), rates)

    @property
    def worst(self) -> float:
        """Of all limbs, in [m]."""
        return float(self.least.min())


class LimbClearance:
    """Balls on the legs of a robot, without the lower half of the shank, which may touch the ground.

    watched: without, there are no balls, and no limb is ever near the ground.
    """

    def __init__(self, robot: Robot, watched: bool = True) -> None:
        bodies = [SwingBodies.of(robot, leg, robot.bodies[leg].swing) for leg in LEGS]
        feet = [np.array([*robot.kinematics[leg].shank]) for leg in LEGS]
        balls = [_balls(each, foot) for each, foot in zip(bodies, feet, strict=True)]
        if not watched:
            balls = [each[:0] for each in balls]
        self._legs = (
            np.array([robot.layout.hips[leg] for leg in LEGS]),
            np.stack([each.leg for each in bodies]),
            np.stack([each.axes for each in bodies]),
            np.concatenate(balls),
            np.cumsum([0, *map(len, balls)]),
        )

    def at(self, elevation_map: ElevationMap, pose: BasePose, feet: Array) -> Clearance:
        """With the base at a pose and the feet's centres at feet (4, 3), by LEGS, in W, in [m].

        Legs out of reach are as long as they can be.
        """
        return Clearance(*self._at(elevation_map, pose, feet, LIMBS))

    def worst(self, elevation_map: ElevationMap, pose: BasePose, feet: Array) -> float:
        """`at(...).worst` without its rates, in a fraction of the time."""
        return float(self._at(elevation_map, pose, feet, 0)[0].min())

    def _at(self, elevation_map: ElevationMap, pose: BasePose, feet: Array, limbs: int) -> tuple[Array, Array]:
        """Clearances, and rates of so many limbs."""
        least, rates = np.empty((4, LIMBS)), np.empty((4, limbs, 5))
        values, ground = np.array(pose.as_list()), _ground(elevation_map)
        _all_legs(values, np.ascontiguousarray(feet), self._legs, ground, least, rates)
        return least, rates

    def of_foot(self, elevation_map: ElevationMap, pose: BasePose, leg: str, feet: Array) -> Array:
        """(n,) the worst limb of one leg with its foot's centre at each of feet (n, 3), all as in `at`."""
        worst = np.empty(len(feet))
        values, ground = np.array(pose.as_list()), _ground(elevation_map)
        _one_foot_at_many_places(values, np.ascontiguousarray(feet), LEGS.index(leg), self._legs, ground, worst)
        return worst


def _ground(elevation_map: ElevationMap) -> Ground:
    corner = elevation_map.position - (np.array(elevation_map.shape) - 1) / 2 * elevation_map.resolution
    return elevation_map.elevation, elevation_map.resolution, corner


def _balls(bodies: SwingBodies, foot: Array) -> Array:
    """(n, 5) link, centre along u, v, w relative to the link's joint, radius; foot: along u and w, from the knee."""
    found = []
    for k, body in enumerate(bodies.bodies):
        axis, half, widths = medial_axis(body.shape)
        radius = float(widths.max())
        # The outer balls end a third of a radius beyond the body, which covers most of its corners.
        reach = max(half - 2 / 3 * radius, 0.0)
        count = ceil(2 * reach / SPACING) + 1
        for along in np.linspace(-reach, reach, count) if count > 1 else (0.0,):
            centre = bodies.centre[k] + along * bodies.rotation[k][:, axis]
            if bodies.link[k] == 0 or np.hypot(*(centre[[0, 2]] - foot)) > LOWER_SHANK:
                found.append([float(bodies.link[k]), *centre, radius])
    return np.array(found)


@compiled
def _all_legs(
    pose: Array,
    feet: Array,
    legs: Legs,
    ground: Ground,
    least: Array,
    rates: Array,
) -> None:  # pragma: no cover - compiled
    """Fill least (4, LIMBS) and rates (4, LIMBS, 5) of a Clearance, or no rates if there is no room for any."""
    for k in range(4):
        _one_leg(pose, feet[k], k, legs, ground, least[k], rates[k])


@compiled
def _one_foot_at_many_places(
    pose: Array,
    feet: Array,
    leg: int,
    legs: Legs,
    ground: Ground,
    worst: Array,
) -> None:  # pragma: no cover - compiled
    """Fill worst (n,): of the limbs of one leg with its foot at each of feet (n, 3)."""
    least, rates = np.empty(LIMBS), np.empty((0, 5))
    for row in range(len(feet)):
        _one_leg(pose, feet[row], leg, legs, ground, least, rates)
        worst[row] = least.min()


@compiled
def _one_leg(
    pose: Array,
    foot: Array,
    k: int,
    legs: Legs,
    ground: Ground,
    least: Array,
    rates: Array,
) -> None:  # pragma: no cover - compiled
    """Fill least (LIMBS,) and rates (LIMBS, 5) or (0, 5) of leg k. pose: (6,)."""
    hips, parameters, axes, balls, ends = legs
    heights, resolution, corner = ground
    rotations, origins = np.empty((2, 3, 3)), np.empty((2, 3))
    hip, centre = np.empty(3), np.empty(3)
    slope, before = np.zeros((LIMBS, 3)), np.zeros((LIMBS, 3))
    worst = np.full(LIMBS, -1)
    least[:], rates[:] = np.inf, 0.0
    _place_leg(pose, foot, hips[k], parameters[k], axes[k], hip, rotations, origins)
    for b in range(ends[k], ends[k + 1]):
        limb = int(balls[b, 0])
        _place_ball(balls[b], hip, rotations, origins, centre)
        radius = balls[b, 4] + DISTANCE
        first_i = max(int(np.ceil((centre[0] - radius - corner[0]) / resolution)), 0)
        last_i = min(int(np.floor((centre[0] + radius - corner[0]) / resolution)), heights.shape[0] - 1)
        first_j = max(int(np.ceil((centre[1] - radius - corner[1]) / resolution)), 0)
        last_j = min(int(np.floor((centre[1] + radius - corner[1]) / resolution)), heights.shape[1] - 1)
        for i in range(first_i, last_i + 1):
            dx = corner[0] + i * resolution - centre[0]
            for j in range(first_j, last_j + 1):
                dy = corner[1] + j * resolution - centre[1]
                square = radius * radius - dx * dx - dy * dy
                if square <= 0.0 or np.isnan(heights[i, j]):
                    continue
                down = np.sqrt(square)
                clear = centre[2] - down - heights[i, j]
                if clear < least[limb]:
                    least[limb], worst[limb] = clear, b
                    before[limb] = centre
                    # How the height of the ball's surface over the cell changes as the ball moves aside.
                    share = max(down, np.sqrt(dx * dx + dy * dy) / STEEPEST)
                    slope[limb, 0], slope[limb, 1], slope[limb, 2] = -dx / share, -dy / share, 1.0
    if len(rates) == 0:
        return
    moved = pose.copy()
    for axis in range(5):
        moved[axis] += SHIFT
        _place_leg(moved, foot, hips[k], parameters[k], axes[k], hip, rotations, origins)
        moved[axis] = pose[axis]
        for limb in range(LIMBS):
            if worst[limb] < 0:
                continue
            _place_ball(balls[worst[limb]], hip, rotations, origins, centre)
            for i in range(3):
                rates[limb, axis] += slope[limb, i] * (centre[i] - before[limb, i]) / SHIFT


@compiled
def _place_leg(
    pose: Array,
    foot: Array,
    hip_in_base: Array,
    leg: Array,
    axes: Array,
    hip: Array,
    rotations: Array,
    origins: Array,
) -> None:  # pragma: no cover - compiled
    """Where hip (3,), and links as of `link_frames` but in W, are when the foot's centre is at foot (3,)."""
    cr, sr, cp, sp, cy, sy = (
        np.cos(pose[3]),
        np.sin(pose[3]),
        np.cos(pose[4]),
        np.sin(pose[4]),
        np.cos(pose[5]),
        np.sin(pose[5]),
    )
    turn = np.empty((3, 3))
    turn[0, 0], turn[0, 1], turn[0, 2] = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    turn[1, 0], turn[1, 1], turn[1, 2] = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    turn[2, 0], turn[2, 1], turn[2, 2] = -sp, cp * sr, cp * cr
    for i in range(3):
        hip[i] = pose[i] + turn[i, 0] * hip_in_base[0] + turn[i, 1] * hip_in_base[1] + turn[i, 2] * hip_in_base[2]
    dx, dy, dz = foot[0] - hip[0], foot[1] - hip[1], foot[2] - hip[2]
    x = turn[0, 0] * dx + turn[1, 0] * dy + turn[2, 0] * dz
    y = turn[0, 1] * dx + turn[1, 1] * dy + turn[2, 1] * dz
    z = turn[0, 2] * dx + turn[1, 2] * dy + turn[2, 2] * dz
    _, haa, hfe, kfe = solve(leg, x, y, z)
    while np.isnan(kfe):
        # Too long, or far too short.
        scale = 0.99 if x * x + y * y + z * z > 0.04 else 1.1
        x, y, z = scale * x, scale * y, scale * z - 1e-6
        _, haa, hfe, kfe = solve(leg, x, y, z)
    in_world = np.empty((3, 3))
    for row in range(3):
        for i in range(3):
            in_world[row, i] = turn[i, 0] * axes[row, 0] + turn[i, 1] * axes[row, 1] + turn[i, 2] * axes[row, 2]
    link_frames(leg, in_world, haa, hfe, kfe, rotations, origins)


@compiled
def _place_ball(
    ball: Array, hip: Array, rotations: Array, origins: Array, centre: Array
) -> None:  # pragma: no cover - compiled
    """Centre (3,) of a ball in W."""
    link = int(ball[0])
    for i in range(3):
        centre[i] = (
            hip[i]
            + origins[link, i]
            + rotations[link, i, 0] * ball[1]
            + rotations[link, i, 1] * ball[2]
            + rotations[link, i, 2] * ball[3]
        )
