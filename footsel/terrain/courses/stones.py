"""Crossing the stream: stepping stones over deep water, between two banks."""

import numpy as np

from footsel.terrain.courses.site import Array, Site, any_direction, chance


def stones(rng: np.random.Generator, site: Site) -> Array:
    """Stones 12 to 40 cm across at +-6 cm, 5 to 25 cm apart, over a bed 0.4 to 0.8 m deep, with banks at both ends.

    Each stone has a cell of a slanted brick pattern to itself, turned to the direction of the crossing, and stays
    at least 2.5 cm inside of it.
    """
    u, v = site.turned(any_direction(rng))
    pitch = rng.uniform(0.24, 0.54)
    row = np.floor(v / pitch).astype(np.intp)
    # Every other row is shifted: a stone faces the gap between two others.
    shift = rng.uniform(0.3, 0.7) * (row % 2)
    column = np.floor(u / pitch + shift).astype(np.intp)
    half = int(site.reach / pitch) + 2
    shape = (2 * half + 1, 2 * half + 1)
    stone = (column + half, row + half)

    smallest, largest = max(0.12, pitch - 0.25), min(0.40, pitch - 0.05)
    length = rng.uniform(smallest, largest, shape)
    aspect = rng.uniform(0.7, 1.0, shape)
    width = np.maximum(length * aspect, 0.12)
    free = (pitch - 0.05 - length) / 2
    yaw = rng.uniform(-np.pi, np.pi, shape)
    # 2 is an ellipse; higher powers are blocks with rounded corners.
    power = rng.uniform(2, 8) if chance(rng, 0.7) else 2.0
    level = rng.uniform(-1, 1, shape) * rng.uniform(0.01, 0.06)
    tilt = np.tan(np.deg2rad(rng.uniform(-6, 6, (2, *shape))))
    missing = rng.random(shape) < 0.04

    du = u - (column - shift + 0.5) * pitch - (free * rng.uniform(-1, 1, shape))[stone]
    dv = v - (row + 0.5) * pitch - (free * rng.uniform(-1, 1, shape))[stone]
    c, s = np.cos(yaw)[stone], np.sin(yaw)[stone]
    along, across = c * du + s * dv, c * dv - s * du
    outline = (np.abs(along) / (length[stone] / 2)) ** power + (np.abs(across) / (width[stone] / 2)) ** power
    # A block must fit into its cell at any yaw, so its corners are cut by the circle of its length.
    on_stone = (outline <= 1) & (along**2 + across**2 <= (length[stone] / 2) ** 2) & ~missing[stone]
    top = level[stone] + tilt[0][stone] * along + tilt[1][stone] * across

    bed = -rng.uniform(0.4, 0.8) + rng.uniform(0, 0.02) * site.noise(rng, 0.4)
    heights = np.where(on_stone, top, bed)
    shore = rng.uniform(0.30, 0.45) * site.size + 0.04 * site.noise(rng, 0.8)
    return np.where(np.abs(u) > shore, 0.0, heights)
