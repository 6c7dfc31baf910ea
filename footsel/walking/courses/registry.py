"""All courses by the name that a user types, and the course of one of them, or of a map file, for a seed."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from footsel.errors import InputError, UnknownNameError
from footsel.terrain import ElevationMap
from footsel.walking.course import WalkCourse
from footsel.walking.courses import ground, obstacles
from footsel.walking.courses.gaps import gaps
from footsel.walking.courses.scanned import course_across
from footsel.walking.courses.stairs import stairs
from footsel.walking.courses.stones import stones
from footsel.walking.courses.strip import Family, strip_course

#: What each built-in terrain is called, and what lays it out.
WALK_COURSES: Mapping[str, Family] = MappingProxyType(
    {
        "flat": ground.flat,
        "slopes": ground.slopes,
        "stairs12": stairs(0.12),
        "stairs": stairs(0.15),
        "stairs17": stairs(0.17),
        "rough": ground.rough,
        "blocks": obstacles.blocks,
        "rubble": obstacles.rubble,
        "stones": stones(narrowest=0.16, widest=0.25, widest_gap=0.15),
        "stones_hard": stones(narrowest=0.12, widest=0.25, widest_gap=0.25),
        "gaps": gaps,
    }
)


def make_walk_course(name: str, seed: int, **map_options: Any) -> WalkCourse:
    """The course of a name in WALK_COURSES, or across the elevation map in a file; the same for the same seed.

    map_options: as of terrain.formats.load, for files that do not say all themselves.
    Raises UnknownNameError for a name that is neither, MapError for a file that makes no course.
    """
    if seed < 0:
        raise InputError(f"seed is {seed}", "expected a whole number from 0")
    if name in WALK_COURSES:
        return strip_course(name, WALK_COURSES[name], np.random.default_rng(seed))
    if not (Path(name).suffix or Path(name).exists()):
        raise UnknownNameError("terrain", name, (*WALK_COURSES, "an elevation map's file"))
    return course_across(name, ElevationMap.load(name, **map_options), np.random.default_rng(seed))
