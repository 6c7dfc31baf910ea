"""Checks of what callers hand to the runtime: numeric, finite and of the expected shape."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from footsel.errors import InputError, MapError
from footsel.footholds import BasePose, Foothold, LegLayout
from footsel.legs import check_leg
from footsel.terrain import CELLS, ElevationMap

#: No coordinate in metres and no angle in radians is larger; arithmetic is safe up to here.
_MOST = 1e9
#: Cell sides of maps that a leg can use, in [m].
_CELL_SIDES = (1e-5, 1e3)


def _as_numbers(what: str, values: ArrayLike, dtype: DTypeLike) -> NDArray[Any]:
    try:
        if np.iscomplexobj(values):
            raise TypeError("complex values")
        # Values beyond float32 turn infinite in the cast; callers refuse those.
        with np.errstate(over="ignore"):
            return np.asarray(values, dtype=dtype)
    except (TypeError, ValueError) as error:
        raise InputError(f"cannot read the {what} as numbers ({error})", "give floats") from None


def checked_heights(local_heights: ArrayLike) -> NDArray[np.float32]:
    """(40, 40) or (n, 40, 40) float32 heights, NaN allowed; raises InputError for anything else."""
    heights = _as_numbers("local heights", local_heights, np.float32)
    if heights.ndim not in (2, 3) or heights.shape[-2:] != (CELLS, CELLS) or heights.shape[0] == 0:
        raise InputError(
            f"local heights have shape {heights.shape}", f"expected ({CELLS}, {CELLS}) or (n, {CELLS}, {CELLS})"
        )
    if np.isinf(heights).any():
        raise InputError("local heights hold infinite values", "mark unknown cells with NaN")
    return heights


def checked_tilt(name: str, tilt: ArrayLike, maps: int) -> NDArray[np.float64]:
    """() or (maps,) finite angles, in [rad]; raises InputError for anything else."""
    angles = _as_numbers(name, tilt, np.float64)
    if angles.shape not in ((), (1,), (maps,)):
        raise InputError(f"{name} has shape {angles.shape}", f"expected one angle, or one for each of {maps} maps")
    if not (np.abs(angles) < _MOST).all():
        raise InputError(f"{name} holds a value that is not finite or absurd", "give angles in rad")
    return angles


def checked_map(elevation_map: ElevationMap) -> ElevationMap:
    """Raises InputError for anything but an ElevationMap of cells that a leg can use."""
    if not isinstance(elevation_map, ElevationMap):
        raise InputError(f"elevation map is a {type(elevation_map).__name__}", "give a footsel.ElevationMap")
    if not _CELL_SIDES[0] <= elevation_map.resolution <= _CELL_SIDES[1]:
        raise MapError(f"the map's cells are {elevation_map.resolution:g} m wide", "give its resolution in metres")
    if not max(map(abs, elevation_map.position.tolist())) < _MOST:
        raise MapError(f"the map's centre is at {elevation_map.position.tolist()}", "give its position in metres")
    return elevation_map


def checked_pose(layout: LegLayout, elevation_map: ElevationMap, base_pose: "BasePose | ArrayLike") -> list[float]:
    """x, y, z, roll, pitch, yaw, all finite, the base on the map; raises InputError for anything else."""
    pose = BasePose.of(base_pose)
    numbers = [pose.x, pose.y, pose.z, pose.roll, pose.pitch, pose.yaw]
    # NaN compares false.
    if not all(abs(number) < _MOST for number in numbers):
        raise InputError(f"base pose is {numbers}", "give six finite numbers: x y z roll pitch yaw, in m and rad")
    x, y = elevation_map.position.tolist()
    half_x, half_y = (side / 2 for side in elevation_map.size)
    # Near the border the map itself decides; in its midst, in scalars, that takes a tenth of the time.
    if not (abs(pose.x - x) < 0.99 * half_x and abs(pose.y - y) < 0.99 * half_y):
        layout.check_on_map(elevation_map, pose)
    return numbers


def checked_poses(base_poses: ArrayLike) -> NDArray[np.float64]:
    """(n, 6) x, y, z, roll, pitch, yaw, all finite; raises InputError for anything else."""
    poses = _as_numbers("base poses", base_poses, np.float64)
    if poses.ndim != 2 or poses.shape[1] != 6:
        raise InputError(f"base poses have shape {poses.shape}", "give (n, 6): x y z roll pitch yaw of each")
    wrong = np.flatnonzero(~(np.abs(poses) < _MOST).all(axis=1))
    if wrong.size:
        raise InputError(f"base pose {wrong[0]} is {poses[wrong[0]].tolist()}", "give finite numbers")
    return poses


def checked_points(
    what: str, points: Mapping[str, ArrayLike] | None, poses: int | None = None
) -> dict[str, NDArray[np.float64]]:
    """leg -> world (x, y) or (x, y, z), or one of these for each of `poses`; all finite.

    Raises InputError for anything else, UnknownNameError for a leg.
    """
    checked = {}
    for leg, point in (points or {}).items():
        check_leg(leg)
        remedy = "give world (x, y) or (x, y, z)"
        try:
            numbers = np.asarray(point, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"{what} of {leg} is {point!r}", remedy) from None
        shapes = {(2,), (3,)} | (set() if poses is None else {(poses, 2), (poses, 3)})
        if numbers.shape not in shapes or not (np.abs(numbers) < _MOST).all():
            shown = numbers.tolist() if numbers.ndim < 2 else f"of shape {numbers.shape}, or not finite"
            raise InputError(f"{what} of {leg} is {shown}", remedy)
        checked[leg] = numbers
    return checked


def checked_previous(previous: "Mapping[str, Foothold | ArrayLike | None] | None") -> dict[str, NDArray[np.float64]]:
    """leg -> (2,) or (3,) world point of the footholds there were; those of status "none" are left out."""
    points: dict[str, ArrayLike] = {}
    for leg, foothold in (previous or {}).items():
        check_leg(leg)
        point = foothold.position if isinstance(foothold, Foothold) else foothold
        if point is not None:
            points[leg] = point
    return checked_points("previous foothold", points)


def checked_count(name: str, count: int) -> int:
    """A whole number of 1 or more; raises InputError for anything else."""
    if not isinstance(count, (int, np.integer)) or count < 1:
        raise InputError(f"{name} is {count!r}", "give a whole number of 1 or more")
    return int(count)


def checked_limit(name: str, limit: float, remedy: str) -> float:
    """A number of 0 or more, inf too, which never binds; raises InputError for anything else."""
    try:
        number = float(limit)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {limit!r}", remedy) from None
    # NaN compares false.
    if not number >= 0:
        raise InputError(f"{name} is {limit!r}", remedy)
    return number
