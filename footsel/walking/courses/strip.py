"""The strip that a walk goes over, along +x from the start at the origin: an obstacle between two flat aprons."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footsel.terrain import ElevationMap
from footsel.terrain.courses.site import Array, Site
from footsel.walking.course import WalkCourse

#: Side of a cell; vertical faces become ramps of this width in physics. [m]
RESOLUTION = 0.02
#: From the start of the base to the obstacle: the front feet stand 0.36 m ahead of the base. [m]
AHEAD = 0.6
#: From the obstacle's end to the goal of the base: there the hind feet have left the obstacle. [m]
BEYOND = 0.55
#: Flat ground behind the start and after the goal: feet, and the local maps around them. [m]
BEHIND, AFTER = 1.2, 1.0
#: The line is walked in the middle; feet stand 0.25 m beside it and their local maps reach 0.4 m further. [m]
HALF_WIDTH = 1.4
#: Obstacles are laid out on a square site of this side, centred on their middle, and cut from it. [m]
SITE_SIZE = 8.0


@dataclass(frozen=True, eq=False)
class Obstacle:
    """What lies between the aprons.

    heights: (n, n) on the site, the obstacle in its middle: 0 before it, level behind it, in [m].
    length: along x in the middle of the strip, in [m].
    """

    heights: Array
    length: float


#: Lays out the obstacle of one family.
Family = Callable[[np.random.Generator, Site], Obstacle]


def strip_course(name: str, family: Family, rng: np.random.Generator) -> WalkCourse:
    """The course of a family: its obstacle between the aprons, the start at the origin and 2 cm cells."""
    site = Site(cells=round(SITE_SIZE / RESOLUTION), resolution=RESOLUTION)
    obstacle = family(rng, site)
    start = -obstacle.length / 2 - AHEAD
    goal = obstacle.length / 2 + BEYOND
    along, across = site.x[:, 0], site.y[0]
    rows = np.flatnonzero((along >= start - BEHIND) & (along <= goal + AFTER))
    columns = np.flatnonzero(np.abs(across) <= HALF_WIDTH)
    heights = obstacle.heights[np.ix_(rows, columns)].astype(np.float32)
    middle = np.array([along[rows].mean() - start, across[columns].mean()])
    ground = ElevationMap(heights, RESOLUTION, middle)
    return WalkCourse(name, ground, ground, start=(0.0, 0.0, 0.0), goal=(goal - start, 0.0))


def fade(site: Site, length: float, over: float) -> Array:
    """(n, n) share of an obstacle: 1 inside, falling to 0 at both of its ends over a distance, in [m]."""
    return np.clip((length / 2 - np.abs(site.x)) / over, 0, 1)
