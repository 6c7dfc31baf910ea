"""All families by name, and one course of one of them."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from footsel.errors import InputError, UnknownNameError
from footsel.terrain.courses import edges, ground, obstacles, stones
from footsel.terrain.courses.site import Family, Site
from footsel.terrain.elevation_map import ElevationMap

#: What each family of terrain is called, and what lays it out.
FAMILIES: Mapping[str, Family] = MappingProxyType(
    {
        "flat": ground.flat,
        "slopes": ground.slopes,
        "stairs": edges.stairs,
        "steps": edges.steps,
        "blocks": obstacles.blocks,
        "rough": ground.rough,
        "gaps": edges.gaps,
        "stones": stones.stones,
        "pillars": obstacles.pillars,
        "rubble": obstacles.rubble,
        "bumps": ground.bumps,
    }
)


def make_course(
    family: str, seed: int | np.random.Generator, size: float = 6.0, resolution: float = 0.02
) -> ElevationMap:
    """A terrain course of a family, centred on the world's origin, its ground near z = 0; the same for the same seed.

    family: a name in FAMILIES.
    seed: a whole number from 0, or a generator to draw from.
    size: side of the square course, in [m].
    resolution: side of a cell, in [m].

    Raises UnknownNameError for a family that does not exist, InputError for a size or resolution that makes no map.
    """
    if family not in FAMILIES:
        raise UnknownNameError("terrain family", family, FAMILIES)
    if not (np.isfinite(size) and resolution > 0 and size >= 2 * resolution):
        raise InputError(f"a course of {size} m with cells of {resolution} m is not possible", "give positive metres")
    if not isinstance(seed, np.random.Generator) and seed < 0:
        raise InputError(f"seed is {seed}", "expected a whole number from 0")
    site = Site(cells=round(size / resolution), resolution=resolution)
    return ElevationMap(FAMILIES[family](np.random.default_rng(seed), site).astype(np.float32), resolution)
