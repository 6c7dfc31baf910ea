"""Local maps on which an exported network is tried and its 8-bit ranges are measured."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import BasePose, LegLayout
from footsel.terrain import CELLS
from footsel.terrain.courses import FAMILIES, make_course

COURSE_SIZE = 4.0
MAPS_PER_COURSE = 10
#: Poses as `footsel compare` draws them: any heading, tilted by up to this much in roll and in pitch. [rad]
MOST_TILT = float(np.deg2rad(10.0))
#: Height of the base above the ground below it, as a share of the standing height.
HEIGHT_SHARES = (0.8, 1.15)


@dataclass(frozen=True, eq=False)
class TrialMaps:
    """n local maps of one leg.

    heights: (n, 40, 40) relative to L_i, NaN = unknown, in [m].
    roll, pitch: (n,) tilt of the base, in [rad].
    origin: in words, where they are from.
    """

    heights: NDArray[np.float32]
    roll: NDArray[np.float64]
    pitch: NDArray[np.float64]
    origin: str

    def __len__(self) -> int:
        return len(self.heights)

    def batches(self, size: int) -> "Iterator[TrialMaps]":
        """The maps in their order, up to `size` at a time."""
        for start in range(0, len(self), size):
            part = slice(start, start + size)
            yield TrialMaps(self.heights[part], self.roll[part], self.pitch[part], self.origin)


def trial_maps(layout: LegLayout, leg: str, count: int, seed: int) -> TrialMaps:
    """Maps of random base poses on courses of every family; near a course's border they are partly unknown."""
    rng = np.random.default_rng(seed)
    heights = np.empty((count, CELLS, CELLS), dtype=np.float32)
    roll, pitch = rng.uniform(-MOST_TILT, MOST_TILT, (2, count))
    families = list(FAMILIES)
    for index in range(count):
        if index % MAPS_PER_COURSE == 0:
            course = make_course(families[index // MAPS_PER_COURSE % len(families)], rng, size=COURSE_SIZE)
        x, y = rng.uniform(-COURSE_SIZE / 2, COURSE_SIZE / 2, 2)
        z = float(course.sample((x, y))) + layout.standing_height * rng.uniform(*HEIGHT_SHARES)
        pose = BasePose(x, y, z, float(roll[index]), float(pitch[index]), rng.uniform(-np.pi, np.pi))
        heights[index] = layout.local_map(course, pose, leg).heights
    origin = f"random base poses on generated courses of {len(families)} families, seed {seed}"
    return TrialMaps(heights, roll, pitch, origin)
