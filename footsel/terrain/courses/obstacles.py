"""Things that stand on the ground: blocks, pillars and walls, rubble."""

import numpy as np

from footsel.terrain.courses.site import Array, Site, Top, any_direction, chance, gentle_ground


def blocks(rng: np.random.Generator, site: Site) -> Array:
    """Boxes 3 to 30 cm high: scattered at any yaw, or a close field of cinder blocks with tilted tops."""
    return _block_field(rng, site) if chance(rng, 0.4) else _scattered_blocks(rng, site)


def pillars(rng: np.random.Generator, site: Site) -> Array:
    """Round and square pillars 5 to 25 cm wide, and walls, 0.2 to 0.8 m high: a leg beside them can hit them."""
    ground = gentle_ground(rng, site)
    heights: Array = ground.copy()
    for _ in range(rng.poisson(rng.uniform(2.5, 5) * site.size**2)):
        x, y = site.any_place(rng)
        width = rng.uniform(0.05, 0.25)
        top = site.height_at(ground, x, y) + rng.uniform(0.2, 0.8)
        if chance(rng, 0.5):
            site.stamp(heights, x, y, width / 2, dome(width, width, 0.0, top, 0.0))
        else:
            site.stamp(heights, x, y, 0.75 * width, box(width, width, any_direction(rng), top))
    direction = any_direction(rng)
    for _ in range(rng.poisson(0.3 * site.size**2)):
        x, y = site.any_place(rng)
        length, thickness = rng.uniform(0.4, 1.6), rng.uniform(0.05, 0.2)
        yaw = direction + rng.integers(2) * np.pi / 2 + rng.normal(0, 0.15)
        top = site.height_at(ground, x, y) + rng.uniform(0.2, 0.8)
        site.stamp(heights, x, y, length, box(length, thickness, yaw, top))
    return heights


def rubble(rng: np.random.Generator, site: Site) -> Array:
    """Tilted blocks and boulders of 6 to 50 cm, 3 to 25 cm high, that lie beside and on top of each other."""
    ground = gentle_ground(rng, site)
    heights: Array = ground.copy()
    boulders = rng.uniform(0.1, 0.9)
    largest = rng.uniform(0.25, 0.5)
    for _ in range(rng.poisson(rng.uniform(12, 28) * site.size**2)):
        x, y = site.any_place(rng)
        # Debris has many small pieces and few large ones.
        length = 0.06 * (largest / 0.06) ** rng.random()
        width = length * rng.uniform(0.5, 1)
        height = np.clip(rng.uniform(0.25, 0.7) * length, 0.03, 0.25)
        yaw = any_direction(rng)
        # A piece has sunk between those below it, so the heap does not grow without end.
        level = site.height_at(ground, x, y)
        level += rng.uniform(0, 0.6) * (site.height_at(heights, x, y) - level)
        if chance(rng, boulders):
            top = dome(length, width, yaw, level, height)
        else:
            top = box(length, width, yaw, level + height, np.tan(np.deg2rad(rng.uniform(-25, 25, 2))))
        site.stamp(heights, x, y, np.hypot(length, width) / 2, top)
    return heights


def _scattered_blocks(rng: np.random.Generator, site: Site) -> Array:
    ground = gentle_ground(rng, site)
    heights: Array = ground.copy()
    highest = rng.uniform(0.08, 0.30)
    tilted = rng.uniform(0, 0.6)
    for _ in range(rng.poisson(rng.uniform(2.5, 5) * site.size**2)):
        x, y = site.any_place(rng)
        length, width = rng.uniform(0.12, 0.6, 2)
        tilt = np.tan(np.deg2rad(rng.uniform(-18, 18, 2))) if chance(rng, tilted) else np.zeros(2)
        level = site.height_at(ground, x, y) + rng.uniform(0.03, highest)
        top = box(length, width, any_direction(rng), level, tilt)
        site.stamp(heights, x, y, np.hypot(length, width) / 2, top)
    return heights


def _block_field(rng: np.random.Generator, site: Site) -> Array:
    """Square stacks of blocks side by side, levels in whole layers, tops level or tilted one of four ways.

    The layout of the rough terrain of the DARPA Robotics Challenge, whose stacks of two blocks are 0.4 m square.
    """
    u, v = site.turned(any_direction(rng))
    side = rng.uniform(0.3, 0.5)
    half = int(site.reach / side) + 2
    shape = (2 * half, 2 * half)
    i, j = np.floor(u / side).astype(np.intp), np.floor(v / side).astype(np.intp)
    stack = (i + half, j + half)
    layer = rng.uniform(0.05, 0.15)
    level = layer * (rng.integers(0, 3, shape) - 1)
    tilt = np.tan(np.deg2rad(rng.uniform(8, 16)))
    ways = tilt * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    way = ways[rng.choice(5, shape, p=[0.3, 0.175, 0.175, 0.175, 0.175])][stack]
    du, dv = u - (i + 0.5) * side, v - (j + 0.5) * side
    return np.asarray(level[stack] + way[..., 0] * du + way[..., 1] * dv)


def box(length: float, width: float, yaw: float, level: float, tilt: Array | None = None) -> Top:
    """Top face of a box at `level` [m] above its middle; `tilt` (2,) is its slope along length and width [m/m]."""
    c, s = np.cos(yaw), np.sin(yaw)

    def top(dx: Array, dy: Array) -> Array:
        along, across = c * dx + s * dy, c * dy - s * dx
        face = level if tilt is None else level + tilt[0] * along + tilt[1] * across
        return np.where((np.abs(along) <= length / 2) & (np.abs(across) <= width / 2), face, np.nan)

    return top


def dome(length: float, width: float, yaw: float, level: float, height: float) -> Top:
    """Upper half of an ellipsoid that rises by `height` from `level` at its rim; a disc for height 0, in [m]."""
    c, s = np.cos(yaw), np.sin(yaw)

    def top(dx: Array, dy: Array) -> Array:
        along, across = (c * dx + s * dy) / (length / 2), (c * dy - s * dx) / (width / 2)
        inside = 1 - along**2 - across**2
        return np.where(inside >= 0, level + height * np.sqrt(np.maximum(inside, 0)), np.nan)

    return top
