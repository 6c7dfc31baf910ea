"""The maps that selectors are compared on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footsel.terrain import ElevationMap
from footsel.terrain.courses import FAMILIES, make_course

#: Keeps the courses' random numbers apart from those of the poses, and from the seeds of training courses.
COURSE_STREAM = 1


@dataclass(frozen=True, eq=False)
class NamedMap:
    """An elevation map and what the report calls it."""

    name: str
    elevation_map: ElevationMap


def built_in_courses(seed: int, families: Sequence[str] = tuple(FAMILIES)) -> list[NamedMap]:
    """One course per family; no seed of a dataset makes the same ones."""
    return [
        NamedMap(family, make_course(family, np.random.default_rng([seed, index, COURSE_STREAM])))
        for index, family in enumerate(families)
    ]
