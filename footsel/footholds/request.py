"""What is asked of a selector: for each leg, its local map and nominal foothold at one base pose."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import InputError
from footsel.footholds.layout import LegLayout
from footsel.footholds.pose import BasePose
from footsel.legs import LEGS, check_leg, check_legs
from footsel.terrain import ElevationMap, LocalMap


@dataclass(frozen=True, eq=False)
class LegRequest:
    """One leg's part of a request.

    local_map: the terrain around the leg. nominal: N_i on the terrain, in the world frame, in [m].
    """

    leg: str
    pose: BasePose
    local_map: LocalMap
    nominal: tuple[float, float, float]


def prepare(
    layout: LegLayout,
    elevation_map: ElevationMap,
    base_pose: "BasePose | ArrayLike",
    legs: Iterable[str] = LEGS,
    nominal: Mapping[str, ArrayLike] | None = None,
) -> list[LegRequest]:
    """Cut the local map of every leg and place its nominal foothold.

    base_pose: x, y, z, roll, pitch, yaw of the base in the world frame, in [m] and [rad].
    nominal: N_i of any leg as world (x, y) or (x, y, z), in [m]; the robot's nominal stance for legs not named.

    Raises InputError for a base off the map and for values that make no sense, UnknownNameError for a leg.
    """
    if not isinstance(elevation_map, ElevationMap):
        raise InputError(f"elevation map is a {type(elevation_map).__name__}", "give a footsel.ElevationMap")
    pose = BasePose.of(base_pose)
    layout.check_on_map(elevation_map, pose)
    given = {check_leg(leg): _checked_point(leg, point) for leg, point in (nominal or {}).items()}
    requests = []
    for leg in check_legs(legs):
        point = given.get(leg, layout.nominal_xy(leg, pose))
        place = (
            (float(point[0]), float(point[1]), float(point[2]))
            if len(point) == 3
            else layout.nominal_position(leg, pose, elevation_map, point)
        )
        requests.append(LegRequest(leg, pose, layout.local_map(elevation_map, pose, leg), place))
    return requests


def _checked_point(leg: str, point: ArrayLike) -> NDArray[np.float64]:
    """(2,) or (3,) finite numbers."""
    try:
        numbers = np.asarray(point, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"nominal foothold of {leg} is {point!r}", "give world (x, y) or (x, y, z)") from None
    if numbers.shape not in ((2,), (3,)) or not np.isfinite(numbers).all():
        raise InputError(f"nominal foothold of {leg} is {numbers.tolist()}", "give world (x, y) or (x, y, z)")
    return numbers
