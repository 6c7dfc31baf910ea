"""Where the two oracles are compared: a leg over a course or a map, and the cells of its local map."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import BasePose, LegLayout
from footsel.terrain import ElevationMap, LocalMap
from footsel.terrain.courses import FAMILIES, make_course

#: Height of the base over the ground, as a share of the standing height: ANYmal B 0.36 to 0.60 m.
HEIGHT_SHARE = (0.74, 1.23)

#: Roll and pitch of the base lie within this. [rad]
TILT = float(np.deg2rad(15.0))

#: Course seeds are drawn below this.
COURSE_SEEDS = 100_000

#: At most this share of the cells of a place is unknown: there is little to compare in them.
UNKNOWN_SHARE = 0.05


@dataclass(frozen=True, eq=False)
class Place:
    """A leg over some terrain.

    source: name of a course family or path of a map. seed: of the course, None for a map.
    pose: of the base. height: of the base over the ground under the feet, in [m]. local_map: the leg's.
    """

    source: str
    seed: int | None
    leg: str
    pose: BasePose
    height: float
    local_map: LocalMap

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch, in [rad]."""
        return self.pose.roll, self.pose.pitch

    def __str__(self) -> str:
        """All that it takes to stand there again: course and seed or map, leg, base pose."""
        terrain = f"map {Path(self.source).name}" if self.seed is None else f"course {self.source} seed {self.seed}"
        return f"{terrain} --leg {self.leg} --pose {' '.join(map(repr, self.pose.as_list()))}"


def draw_place(layout: LegLayout, source: str, leg: str, rng: np.random.Generator) -> Place:
    """A random base pose over a random course of a family, or over a map file."""
    seed = int(rng.integers(COURSE_SEEDS)) if source in FAMILIES else None
    return draw_pose(layout, source, seed, open_source(source, seed), leg, rng)


def open_source(source: str, seed: int | None) -> ElevationMap:
    """The course of a family with its seed, or the map file."""
    return ElevationMap.load(source) if seed is None else make_course(source, seed)


def draw_pose(
    layout: LegLayout, source: str, seed: int | None, elevation_map: ElevationMap, leg: str, rng: np.random.Generator
) -> Place:
    """A base pose over known ground: any yaw, heights in HEIGHT_SHARE, roll and pitch within TILT."""
    known = np.argwhere(elevation_map.known)
    while True:
        i, j = known[rng.integers(len(known))]
        x, y = float(elevation_map.x()[i]), float(elevation_map.y()[j])
        yaw = float(rng.uniform(-np.pi, np.pi))
        ground = layout.ground_height(elevation_map, x, y, yaw)
        if not np.isnan(ground):
            break
    roll, pitch = rng.uniform(-TILT, TILT, 2).tolist()
    height = float(rng.uniform(*HEIGHT_SHARE)) * layout.standing_height
    pose = BasePose(x, y, ground + height, roll, pitch, yaw)
    return Place(source, seed, leg, pose, height, layout.local_map(elevation_map, pose, leg))


def draw_cells(local_map: LocalMap, most: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """(k, 2) random cells, `most` of them if enough are known; few of them unknown."""
    known, unknown = (rng.permutation(np.argwhere(which)) for which in (local_map.known, ~local_map.known))
    unknown = unknown[: int(UNKNOWN_SHARE * most)]
    return np.concatenate([known[: most - len(unknown)], unknown])
