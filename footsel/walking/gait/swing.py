"""The way of a swinging foot: up, over what the map says lies between, and down."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.terrain import ElevationMap
from footsel.walking.control.quintic import Quintic

Array = NDArray[np.float64]

#: Above everything within FOOT_WIDTH of the path, foot radius not counted. [m]
CLEARANCE = 0.05
#: How far beside the path the ground counts: the foot's radius, a map's cell, errors of tracking. [m]
FOOT_WIDTH = 0.055
#: Over unknown ground the foot goes this much higher than over the highest known of the path. [m]
CAUTION = 0.06
#: Least rise above both ends. [m]
LIFT = 0.06
#: So near to its ends the path may be close to the ground, but no deeper in what is under the foot than this. [m]
ENDS, ROUGHNESS = 0.05, 0.012
#: Largest accelerations up, along and down: the base has to hold against the leg. [m/s^2]
RISE, ALONG, SINK = 9.0, 10.0, 7.0
SHORTEST_PHASE = 0.12
#: How fast a foot comes down, and sinks on if the ground is late. [m/s]
TOUCHDOWN_SPEED = 0.15
#: Shares of the rise and of the sinking during which the foot does not move forward: tried from the boldest on.
WAITS = (0.35, 0.5, 0.65, 0.8, 1.0)
SAMPLES = 33

_OFFSETS = FOOT_WIDTH * np.array(
    [[0.0, 0.0]] + [[r * np.cos(a), r * np.sin(a)] for r in (0.6, 1.0) for a in np.arange(8) * np.pi / 4]
)
#: The first of these lie under the foot.
_CLOSE = 9


@dataclass(frozen=True, eq=False)
class Swing:
    """along: motion of the foot centre's xy. up, down: motion of its z, `down` once it has begun, all in W."""

    along: Quintic
    up: Quintic
    down: Quintic

    @property
    def start(self) -> float:
        """When the foot begins to rise, in [s]."""
        return self.up.start

    @property
    def end(self) -> float:
        """When the foot should touch the ground, in [s]."""
        return self.down.end

    def at(self, time: float) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration (3,) of the foot's centre; after the end it sinks on."""
        rise = self.down if time >= self.down.start else self.up
        if time > self.along.end:
            xy = (self.along.at(self.along.end)[0], np.zeros(2), np.zeros(2))
        else:
            xy = self.along.at(time)
        z = rise.at(time) if rise is self.down or time <= rise.end else (rise.at(rise.end)[0], np.zeros(1), np.zeros(1))
        return tuple(np.concatenate(pair) for pair in zip(xy, z, strict=True))  # type: ignore[return-value]


def plan_swing(elevation_map: ElevationMap, start: float, foot: Array, goal: Array, foot_radius: float) -> Swing:
    """A swing of a foot's centre from `foot` (3,) to `goal` (3,) in W, that begins at time `start`.

    It sinks at TOUCHDOWN_SPEED when it arrives and goes on until the ground is felt.
    """
    needed = required_height(elevation_map, foot, goal, foot_radius)
    apex = max(float(needed.max()), foot[2] + LIFT, goal[2] + LIFT)
    distance = float(np.linalg.norm(goal[:2] - foot[:2]))
    rise, sink = _duration(apex - foot[2], RISE), _duration(apex - goal[2], SINK)
    travel = _duration(distance, ALONG)
    swing = None
    for wait in WAITS:
        along_start = start + wait * rise
        along_end = along_start + travel
        # Down comes after up, and ends after the foot is over its goal by the share that it waits.
        down_start = max(along_end - (1 - wait) * sink, start + rise)
        zero = np.zeros(2)
        swing = Swing(
            along=Quintic.between(along_start, travel, (foot[:2], zero, zero), goal[:2], zero),
            up=Quintic.between(start, rise, (foot[2:], zero[:1], zero[:1]), [apex], zero[:1]),
            down=Quintic.between(down_start, sink, ([apex], zero[:1], zero[:1]), goal[2:], [-TOUCHDOWN_SPEED]),
        )
        if _is_clear(swing, start, foot, goal, needed):
            break
    assert swing is not None
    return swing


def _duration(distance: float, acceleration: float) -> float:
    """Of a quintic from rest to rest, whose acceleration peaks at 5.77 times distance over duration squared, in [s]."""
    return max(float(np.sqrt(5.77 * distance / acceleration)), SHORTEST_PHASE)


def required_height(elevation_map: ElevationMap, foot: Array, goal: Array, foot_radius: float) -> Array:
    """(SAMPLES,) height that the foot's centre needs along the straight way from `foot` to `goal`, in [m]."""
    share = np.linspace(0, 1, SAMPLES)[:, None]
    path = foot[:2] + share * (goal[:2] - foot[:2])
    ground = elevation_map.sample(path[:, None] + _OFFSETS).astype(np.float64)
    unknown = np.isnan(ground).any(axis=1)
    ground = np.where(np.isnan(ground), -np.inf, ground)
    known, below = ground.max(axis=1), ground[:, :_CLOSE].max(axis=1)
    highest = max(float(known.max()), foot[2] - foot_radius, goal[2] - foot_radius)
    needed = np.where(unknown, np.maximum(known, highest + CAUTION), known) + CLEARANCE + foot_radius
    distance = np.linalg.norm(goal[:2] - foot[:2])
    near = np.minimum(share[:, 0], 1 - share[:, 0]) * distance < min(ENDS, distance / 2)
    return np.asarray(np.where(near, below + foot_radius - ROUGHNESS, needed))


def _is_clear(swing: Swing, start: float, foot: Array, goal: Array, needed: Array) -> bool:
    """Whether the foot is never below what the place where it is needs."""
    direction = goal[:2] - foot[:2]
    length = float(direction @ direction)
    if length < 1e-8:
        return True
    for time in np.linspace(start, swing.end, 40).tolist():
        position = swing.at(time)[0]
        share = float((position[:2] - foot[:2]) @ direction) / length
        index = min(max(round(share * (SAMPLES - 1)), 0), SAMPLES - 1)
        if position[2] < needed[index] - 1e-3:
            return False
    return True
