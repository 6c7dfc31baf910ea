"""Ground to walk over, from a start to a goal."""

from dataclasses import dataclass

from footsel.terrain import ElevationMap


@dataclass(frozen=True, eq=False)
class WalkCourse:
    """What a walk crosses.

    name: as the user typed it. ground: the true terrain in W, without holes; physics stands on it.
    known: what is known of it beforehand; scanned maps keep their holes here. Otherwise the same map as `ground`.
    start: x, y and yaw of the base, in [m] and [rad]. goal: x, y that the base has to reach, in [m]; the way
    there is the straight line from the start.
    """

    name: str
    ground: ElevationMap
    known: ElevationMap
    start: tuple[float, float, float]
    goal: tuple[float, float]
