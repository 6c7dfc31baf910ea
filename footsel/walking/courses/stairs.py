"""Stairs up and down."""

import numpy as np

from footsel.terrain.courses.site import Site
from footsel.walking.courses.strip import Family, Obstacle

#: How much a riser and a tread may differ from their flight's, as built ones do. [m]
RISER_TOLERANCE, TREAD_TOLERANCE = 0.003, 0.005


def stairs(rise: float) -> Family:
    """Flights of 5 or 6 risers of `rise` [m] up, then down, on treads of 27 to 32 cm, with a landing between them.

    Each flight has a tread and, up to 8 degrees askew, a heading of its own.
    """

    def layout(rng: np.random.Generator, site: Site) -> Obstacle:
        counts = rng.integers(5, 7, 2)
        treads = rng.uniform(0.27, 0.32, 2)
        headings = np.deg2rad(rng.uniform(-8, 8, 2))
        landing = rng.uniform(0.6, 1.0)
        edges = [_edges(rng, count, tread) for count, tread in zip(counts, treads, strict=True)]
        length = edges[0][-1] + landing + edges[1][-1]
        # Flights turn about where the middle line meets their first edge, so the length there stays.
        starts = (-length / 2, length / 2 - edges[1][-1])
        heights = site.flat()
        for sign, start, at, heading in zip((1, -1), starts, edges, headings, strict=True):
            risers = rise + rng.uniform(-RISER_TOLERANCE, RISER_TOLERANCE, len(at))
            u = np.cos(heading) * (site.x - start) + np.sin(heading) * site.y
            # A hair, so that an edge on a cell's centre does not depend on rounding.
            heights += np.concatenate([[0], sign * np.cumsum(risers)])[np.searchsorted(at, u + 1e-9)]
        return Obstacle(heights, float(length))

    return layout


def _edges(rng: np.random.Generator, count: int, tread: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """(count,) where the risers of a flight stand, the first at 0, in [m]."""
    treads = tread + rng.uniform(-TREAD_TOLERANCE, TREAD_TOLERANCE, count - 1)
    return np.concatenate([[0.0], np.cumsum(treads)])
