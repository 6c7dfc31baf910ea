"""Things that lie on the ground, close to each other: blocks and rubble."""

import numpy as np

from footsel.terrain.courses.obstacles import box, dome
from footsel.terrain.courses.site import Array, Site, any_direction, chance
from footsel.walking.courses.strip import HALF_WIDTH, Obstacle

HIGHEST_BLOCK = 0.18


def blocks(rng: np.random.Generator, site: Site) -> Obstacle:
    """Blocks of up to 18 cm that cover most of the ground: side by side in a field, or scattered at any yaw."""
    length = rng.uniform(2.6, 3.1)
    return Obstacle(_field(rng, site, length) if chance(rng, 0.4) else _scattered(rng, site, length), length)


def rubble(rng: np.random.Generator, site: Site) -> Obstacle:
    """Tilted slabs and boulders of 8 to 45 cm beside and on top of each other, up to about 25 cm high."""
    length = rng.uniform(2.6, 3.1)
    heights = site.flat()
    boulders = rng.uniform(0.2, 0.8)
    largest = rng.uniform(0.3, 0.45)
    for _ in range(_count(rng, 24, 34, length)):
        # Debris has many small pieces and few large ones.
        size = 0.08 * (largest / 0.08) ** rng.random()
        width = size * rng.uniform(0.5, 1)
        rise = np.clip(rng.uniform(0.2, 0.55) * size, 0.03, 0.14)
        radius = float(np.hypot(size, width)) / 2
        x, y = _place(rng, length, radius)
        # A piece has sunk between those below it, so the heap does not grow without end.
        level = rng.uniform(0, 0.5) * site.height_at(heights, x, y)
        yaw = any_direction(rng)
        if chance(rng, boulders):
            top = dome(size, width, yaw, level, rise)
        else:
            top = box(size, width, yaw, level + rise, np.tan(np.deg2rad(rng.uniform(-20, 20, 2))))
        site.stamp(heights, x, y, radius, top)
    return Obstacle(heights, length)


def _scattered(rng: np.random.Generator, site: Site, length: float) -> Array:
    """Boxes at any yaw, some of them with tilted tops, that overlap."""
    heights = site.flat()
    tilted = rng.uniform(0, 0.6)
    for _ in range(_count(rng, 11, 14, length)):
        sides = rng.uniform(0.18, 0.45, 2)
        tilt = np.tan(np.deg2rad(rng.uniform(-8, 8, 2))) if chance(rng, tilted) else np.zeros(2)
        level = rng.uniform(0.06, HIGHEST_BLOCK) - float(np.abs(tilt) @ sides) / 2
        radius = float(np.hypot(*sides)) / 2
        x, y = _place(rng, length, radius)
        site.stamp(heights, x, y, radius, box(sides[0], sides[1], any_direction(rng), level, tilt))
    return heights


def _field(rng: np.random.Generator, site: Site, length: float) -> Array:
    """Square blocks side by side on a grid askew to the line, of four levels, some with tilted tops."""
    yaw = np.deg2rad(rng.uniform(-25, 25))
    u, v = site.turned(yaw)
    side = rng.uniform(0.28, 0.42)
    half = int(site.reach / side) + 2
    shape = (2 * half, 2 * half)
    i, j = np.floor(u / side).astype(np.intp), np.floor(v / side).astype(np.intp)
    block = (i + half, j + half)
    level = rng.uniform(0.13, HIGHEST_BLOCK) * rng.choice(4, shape, p=[0.1, 0.3, 0.3, 0.3]) / 3
    tilt = np.tan(np.deg2rad(rng.uniform(-8, 8, (2, *shape)))) * (rng.random(shape) < 0.5)
    level = np.maximum(level - np.abs(tilt).sum(axis=0) * side / 2, 0)
    tilt *= level > 0
    centre_u, centre_v = (i + 0.5) * side, (j + 0.5) * side
    top = level[block] + tilt[0][block] * (u - centre_u) + tilt[1][block] * (v - centre_v)
    # Whole blocks alone: none is cut where the apron begins.
    centre_x = np.cos(yaw) * centre_u - np.sin(yaw) * centre_v
    return np.where(np.abs(centre_x) <= (length - np.sqrt(2) * side) / 2, np.maximum(top, 0), 0.0)


def _count(rng: np.random.Generator, fewest: float, most: float, length: float) -> int:
    """Number of things for a density between the two, per square metre."""
    return int(rng.poisson(rng.uniform(fewest, most) * length * 2 * HALF_WIDTH))


def _place(rng: np.random.Generator, length: float, radius: float) -> tuple[float, float]:
    """Where a thing of this radius lies within the obstacle, in [m]."""
    x = rng.uniform(-length / 2 + radius, length / 2 - radius)
    return float(x), float(rng.uniform(-HALF_WIDTH - radius, HALF_WIDTH + radius))
