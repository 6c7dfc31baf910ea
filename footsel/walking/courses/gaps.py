"""Trenches to step over."""

import numpy as np

from footsel.terrain.courses.site import Site, chance
from footsel.walking.courses.strip import Obstacle


def gaps(rng: np.random.Generator, site: Site) -> Obstacle:
    """Trenches 10 to 25 cm wide and 0.4 to 0.6 m deep every 0.3 to 0.7 m, up to 14 degrees askew; some wind."""
    count = 40
    widths, between = rng.uniform(0.10, 0.25, count), rng.uniform(0.3, 0.7, count)
    # The first trench that ends beyond the length is the last one.
    ends = np.cumsum(widths + between) - between
    last = int(np.searchsorted(ends, rng.uniform(2.5, 2.9)))
    length, starts = ends[last], ends[: last + 1] - widths[: last + 1]
    headings = np.deg2rad(rng.uniform(-10, 10) + rng.uniform(-4, 4, last + 1))
    winding = rng.uniform(0.01, 0.02) * site.noise(rng, rng.uniform(0.4, 0.8)) if chance(rng, 0.4) else site.flat()
    heights = site.flat()
    for start, width, heading in zip(starts, widths, headings, strict=False):
        at = start - length / 2
        u = np.cos(heading) * (site.x - at) + np.sin(heading) * site.y + winding
        heights[(u >= 0) & (u < width)] = -rng.uniform(0.4, 0.6)
    return Obstacle(heights, float(length))
