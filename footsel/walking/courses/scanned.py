"""A course across an elevation map that others made: which line to walk, aprons at its ends, ground in its holes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import InputError, MapError
from footsel.terrain import ElevationMap
from footsel.terrain.courses.site import chance
from footsel.walking.course import WalkCourse
from footsel.walking.courses.strip import AFTER, AHEAD, BEHIND, BEYOND

Array = NDArray[np.float64]

#: Lines tried per axis of the map, and how far each may be askew to it, in [rad].
LINES, ASKEW = 150, float(np.deg2rad(6))
#: Where feet come to stand beside the line, left and right: 0.25 m, within 0.1 m. [m]
TRACKS = np.array([[0.15, 0.20, 0.25, 0.30, 0.35], [-0.15, -0.20, -0.25, -0.30, -0.35]])
#: Along the line: distance of two looks at a track, and how much of it one look takes in. [m]
STEP, LOOK = 0.04, 0.4
#: A look at a track that knows less than this share of its cells wants ground. More height than this along one look,
#: or between the left and the right track of it, is too much for legs. [-], [m]
ENOUGH, ALONG, ACROSS = 0.6, 0.35, 0.18
#: No crossing is shorter, nor shorter than this share of the longest one. [m], [-]
SHORTEST, NEARLY = 0.5, 0.9
#: Length of ground that a crossing may want beyond the best one. [m]
TOLERATED = 0.05
#: Half the width of an apron, and of what is kept of the map beside the line. [m]
APRON_HALF_WIDTH, KEPT_HALF_WIDTH = 1.0, 1.6


@dataclass(frozen=True, eq=False)
class Line:
    """A directed line over the map.

    origin: (2,) a point of it, world xy in [m]. yaw: its direction, in [rad].
    first, last: where along it the crossing begins and ends, in [m]. want: length of it that
    wants ground, in [m].
    """

    origin: Array
    yaw: float
    first: float
    last: float
    want: float

    def coordinates(self, xy: Array) -> tuple[Array, Array]:
        """Along the line and to its left of world points (..., 2), in [m]."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        dx, dy = xy[..., 0] - self.origin[0], xy[..., 1] - self.origin[1]
        return c * dx + s * dy, c * dy - s * dx

    def point(self, along: float) -> Array:
        """(2,) world xy at a distance along the line, in [m]."""
        return np.asarray(self.origin + along * np.array([np.cos(self.yaw), np.sin(self.yaw)]))


def course_across(
    name: str,
    elevation_map: ElevationMap,
    rng: np.random.Generator,
    start: ArrayLike | None = None,
    goal: ArrayLike | None = None,
) -> WalkCourse:
    """A course over the map, in its own coordinates and cells; physics fills the holes, `known` keeps them.

    start, goal: (2,) base positions on the map, in [m]. Without them, one of the longest crossings with known ground
    under both sides of the robot is drawn, either way, and a flat apron is added at each of its ends, as high as the
    map's edge there.
    Raises InputError for a start or goal off the map, MapError for a map that nothing crosses.
    """
    if start is not None and goal is not None:
        a, b = (_on_map(elevation_map, point) for point in (start, goal))
        yaw = float(np.arctan2(*(b - a)[::-1]))
        return WalkCourse(name, _filled(elevation_map), elevation_map, (a[0], a[1], yaw), (b[0], b[1]))
    line = _draw_line(elevation_map, rng)
    known = _with_aprons(elevation_map, line)
    a, b = line.point(line.first - AHEAD).tolist(), line.point(line.last + BEYOND).tolist()
    return WalkCourse(name, _filled(known), known, (a[0], a[1], line.yaw), (b[0], b[1]))


def _draw_line(elevation_map: ElevationMap, rng: np.random.Generator) -> Line:
    """Among many lines, the first drawn of those that are nearly as long and as well supported as any."""
    yaws = [0.0, np.pi / 2]
    if chance(rng, 0.5):
        yaws = [yaw - np.pi for yaw in yaws]
    lines = [
        line
        for _ in range(LINES)
        for yaw in yaws
        if (line := _look_along(elevation_map, yaw + rng.uniform(-ASKEW, ASKEW), rng.uniform(-0.5, 0.5))) is not None
    ]
    if not lines:
        raise MapError("no line across the map has ground for both sides of the robot", "give a larger map")
    longest = max(line.last - line.first for line in lines)
    long = [line for line in lines if line.last - line.first >= NEARLY * longest]
    bound = min(line.want for line in long) + TOLERATED
    return next(line for line in long if line.want <= bound)


def _look_along(elevation_map: ElevationMap, yaw: float, beside: float) -> Line | None:
    """The line of this direction that passes the map's middle at `beside` of its width; None if it crosses nothing."""
    direction = np.array([np.cos(yaw), np.sin(yaw)])
    left = np.array([-direction[1], direction[0]])
    size = np.array(elevation_map.size)
    origin = elevation_map.position + beside * float(np.abs(left) @ size) * left
    reach = float(np.hypot(*size)) / 2 + LOOK
    along = np.arange(-reach, reach, STEP)
    points = origin + along[:, None, None, None] * direction + TRACKS[..., None] * left
    heights = elevation_map.sample(points).astype(np.float64)  # (looks, side, track)

    known = ~np.isnan(heights)
    share = _windows(known).mean(axis=(2, 3)).min(axis=1)
    crossed = np.flatnonzero(share >= ENOUGH)
    if len(crossed) == 0 or (crossed[-1] - crossed[0]) * STEP < SHORTEST:
        return None
    inside = slice(crossed[0], crossed[-1] + 1)
    want = STEP * (np.maximum(1 - share[inside] / ENOUGH, 0) + _too_steep(heights, known)[inside]).sum()
    # A look may begin before the ground does, and end behind it.
    ground = np.flatnonzero(known.mean(axis=2).min(axis=1) >= ENOUGH)
    first = ground[np.searchsorted(ground, crossed[0])]
    last = ground[np.searchsorted(ground, crossed[-1] + round(LOOK / STEP)) - 1]
    return Line(origin, yaw, float(along[first]), float(along[last]), float(want))


def _too_steep(heights: Array, known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(looks,) whether the ground climbs too much in a look, or one side of it lies too far above the other."""
    windows = _windows(heights[:, :, TRACKS.shape[1] // 2])
    climb = np.fmax.reduce(windows, axis=-1) - np.fmin.reduce(windows, axis=-1)
    total = _windows(np.where(known, heights, 0)).sum(axis=(2, 3))
    with np.errstate(invalid="ignore"):
        left, right = (total / _windows(known).sum(axis=(2, 3))).T
    return np.asarray((climb > ALONG).any(axis=1) | (np.abs(left - right) > ACROSS))


def _windows(values: NDArray[np.generic]) -> NDArray[np.generic]:
    """All looks along the first axis, what each takes in as the last axis."""
    return np.lib.stride_tricks.sliding_window_view(values, round(LOOK / STEP), axis=0)


def _with_aprons(elevation_map: ElevationMap, line: Line) -> ElevationMap:
    """The map around the line in its own cells, and flat aprons before and behind it."""
    first, last = line.first - AHEAD - BEHIND, line.last + BEYOND + AFTER
    left = np.array([-np.sin(line.yaw), np.cos(line.yaw)])
    corners = [line.point(at) + side * KEPT_HALF_WIDTH * left for at in (first, last) for side in (-1, 1)]
    index = np.rint(elevation_map.fractional_index(np.array(corners))).astype(int)
    low, high = index.min(axis=0), index.max(axis=0)
    elevation = np.full(high - low + 1, np.nan, dtype=np.float32)
    overlap = tuple(slice(max(a, 0), min(b + 1, n)) for a, b, n in zip(low, high, elevation_map.shape, strict=True))
    place = tuple(slice(part.start - a, part.stop - a) for part, a in zip(overlap, low, strict=True))
    elevation[place] = elevation_map.elevation[overlap]
    middle = (low + high) / 2 - (np.array(elevation_map.shape) - 1) / 2
    position = elevation_map.position + middle * elevation_map.resolution
    canvas = ElevationMap(elevation, elevation_map.resolution, position)

    along, beside = line.coordinates(np.stack(np.meshgrid(canvas.x(), canvas.y(), indexing="ij"), axis=-1))
    near, apron = np.abs(beside) <= TRACKS.max(), np.abs(beside) <= APRON_HALF_WIDTH
    for before, edge in (
        ((along >= first) & (along < line.first), (along >= line.first) & (along < line.first + LOOK / 2)),
        ((along <= last) & (along > line.last), (along <= line.last) & (along > line.last - LOOK / 2)),
    ):
        elevation[before & apron] = np.nanmedian(elevation[edge & near])
    return ElevationMap(elevation, canvas.resolution, canvas.position)


def _filled(elevation_map: ElevationMap) -> ElevationMap:
    """A copy whose unknown cells are as high as the known cell nearest to each."""
    from scipy import ndimage

    nearest = ndimage.distance_transform_edt(~elevation_map.known, return_distances=False, return_indices=True)
    return ElevationMap(elevation_map.elevation[tuple(nearest)], elevation_map.resolution, elevation_map.position)


def _on_map(elevation_map: ElevationMap, point: ArrayLike) -> Array:
    xy = np.asarray(point, dtype=np.float64)
    if not elevation_map.contains(xy):
        raise InputError(f"{xy.tolist()} is off the map", "give x and y of the base on the map, in metres")
    return xy
