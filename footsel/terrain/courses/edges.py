"""Ground that changes its level along straight edges: steps, stairs, gaps."""

import numpy as np

from footsel.terrain.courses.site import (
    Array,
    Site,
    any_direction,
    bounded_walk,
    chance,
    gentle_ground,
    lengths_to_cover,
)


def steps(rng: np.random.Generator, site: Site) -> Array:
    """Single rises of 3 to 25 cm up or down, in one direction, or plateaus where two directions cross."""
    yaw = any_direction(rng)
    if chance(rng, 0.4):
        heights = _terraces(rng, site, yaw, 0.45, 0.9)
    else:
        crossing = yaw + rng.uniform(np.pi / 4, 3 * np.pi / 4)
        heights = _terraces(rng, site, yaw, 0.7, 1.5) + _terraces(rng, site, crossing, 0.7, 1.5)
    return heights + gentle_ground(rng, site)


def stairs(rng: np.random.Generator, site: Site) -> Array:
    """Flights of rises of 8 to 20 cm and treads of 22 to 40 cm, up and down, with landings, in lanes side by side."""
    u, v = site.turned(any_direction(rng))
    lanes = lengths_to_cover(rng, 1.2, 4.0, site)
    lane = np.searchsorted(lanes, v)
    heights = site.flat()
    for number in range(len(lanes) + 1):
        edges, levels = _flights(rng, site)
        here = lane == number
        heights[here] = levels[np.searchsorted(edges, u[here])]
    return heights - np.median(heights)


def gaps(rng: np.random.Generator, site: Site) -> Array:
    """Trenches 5 to 35 cm wide and 0.3 to 0.8 m deep in any direction, straight or winding, some of them crossing."""
    yaw = any_direction(rng)
    trench = _trenches(rng, site, yaw, 0.35, 0.9)
    if chance(rng, 0.5):
        trench = np.minimum(trench, _trenches(rng, site, yaw + rng.uniform(np.pi / 5, 4 * np.pi / 5), 0.9, 2.5))
    return gentle_ground(rng, site) + trench


def _terraces(rng: np.random.Generator, site: Site, yaw: float, shortest: float, longest: float) -> Array:
    """(n, n) level terraces along `yaw`, a rise of 3 to 25 cm between two of them."""
    edges = lengths_to_cover(rng, shortest, longest, site)
    rises = rng.uniform(0.03, 0.25, len(edges)) * rng.choice([-1, 1], len(edges))
    levels = bounded_walk(rises, 0.4)
    return (levels - np.median(levels))[np.searchsorted(edges, site.turned(yaw)[0])]


def _flights(rng: np.random.Generator, site: Site) -> tuple[Array, Array]:
    """Edges (k,) and levels (k + 1,) of a lane: flights of 3 to 6 rises and landings of 0.5 to 1.1 m, in [m]."""
    edges: list[float] = []
    rises: list[float] = []
    at = -site.reach - rng.uniform(0, 2)
    direction = rng.choice([-1, 1])
    level = 0.0
    while at < site.reach:
        rise, tread = rng.uniform(0.08, 0.20), rng.uniform(0.22, 0.40)
        count = int(rng.integers(3, 7))
        # Back towards the middle level when far from it, else on in either direction.
        if abs(level) > 0.4:
            direction = -np.sign(level)
        elif chance(rng, 0.5):
            direction = -direction
        edges.extend(at + tread * np.arange(count))
        rises.extend([direction * rise] * count)
        level += direction * rise * count
        at += tread * (count - 1) + rng.uniform(0.5, 1.1)
    levels = np.concatenate([[0.0], np.cumsum(rises)])
    return np.array(edges), levels - np.median(levels)


def _trenches(rng: np.random.Generator, site: Site, yaw: float, nearest: float, farthest: float) -> Array:
    """(n, n) floor of parallel trenches, the ground between two of them about `nearest` to `farthest` [m] wide."""
    u, _ = site.turned(yaw)
    if chance(rng, 0.4):
        u = u + rng.uniform(0.02, 0.06) * site.noise(rng, rng.uniform(0.5, 1.2))
    starts = lengths_to_cover(rng, nearest + 0.2, farthest + 0.2, site)
    widths = rng.uniform(0.05, 0.35, len(starts))
    depths = rng.uniform(0.3, 0.8, len(starts))
    number = np.searchsorted(starts, u) - 1
    inside = (number >= 0) & (u < (starts + widths)[number])
    return np.where(inside, -depths[number], 0.0)
