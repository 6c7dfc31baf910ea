"""Base poses on terrain courses of every family: what the stages are timed on."""

from dataclasses import dataclass

import numpy as np

from footsel.footholds import BasePose, LegLayout
from footsel.legs import LEGS
from footsel.terrain import ElevationMap, LocalMap
from footsel.terrain.courses import FAMILIES, make_course

#: So many cases in a row are of the same leg: a gait asks for one swing leg again and again.
ROUND = 10
#: Side of a course, and how far from its middle the base stands at most: local maps are wholly known. [m]
COURSE_SIZE, MOST_OFFSET = 4.0, 1.0
#: Roll and pitch of tilted poses lie within this, in [rad].
MOST_TILT = float(np.deg2rad(10.0))
#: Height of the base above the ground under the feet, as a share of the standing height.
HEIGHT_SHARES = (0.8, 1.15)


@dataclass(frozen=True, eq=False)
class Case:
    """One base pose on one course, and the leg that is asked for where it is one leg."""

    family: str
    elevation_map: ElevationMap
    pose: BasePose
    leg: str

    @property
    def tilted(self) -> bool:
        """Whether the base is rolled or pitched."""
        return self.pose.roll != 0.0 or self.pose.pitch != 0.0

    def local_map(self, layout: LegLayout) -> LocalMap:
        """The local map of the case's leg."""
        return layout.local_map(self.elevation_map, self.pose, self.leg)


def make_cases(layout: LegLayout, count: int, seed: int) -> list[Case]:
    """`count` cases: families take turns, every other time tilted; a leg stays for a ROUND, as in a swing."""
    rng = np.random.default_rng(seed)
    courses = [(family, make_course(family, rng, size=COURSE_SIZE)) for family in FAMILIES]
    cases = []
    for number in range(count):
        family, course = courses[number % len(courses)]
        x, y = rng.uniform(-MOST_OFFSET, MOST_OFFSET, 2)
        yaw = rng.uniform(-np.pi, np.pi)
        tilted = number // len(courses) % 2
        roll, pitch = rng.uniform(-MOST_TILT, MOST_TILT, 2) if tilted else (0.0, 0.0)
        z = layout.ground_height(course, x, y, yaw) + rng.uniform(*HEIGHT_SHARES) * layout.standing_height
        pose = BasePose.of([x, y, z, roll, pitch, yaw])
        cases.append(Case(family, course, pose, LEGS[number // ROUND % len(LEGS)]))
    return cases
