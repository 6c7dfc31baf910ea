"""Ground to walk over that has no edges: flat, slopes up and down, rough."""

import numpy as np

from footsel.terrain.courses import ground
from footsel.terrain.courses.site import Site, chance
from footsel.walking.courses.strip import Obstacle, fade


def flat(rng: np.random.Generator, site: Site) -> Obstacle:
    """Level ground, 2.5 to 3.2 m of it."""
    return Obstacle(site.flat(), rng.uniform(2.5, 3.2))


def slopes(rng: np.random.Generator, site: Site) -> Obstacle:
    """A ridge or a valley: slopes of 15 to 20 degrees, level ground between them, up to 15 degrees askew."""
    lengths = rng.uniform([1.1, 0.4, 1.1], [1.4, 0.8, 1.4])
    angles = np.deg2rad(rng.uniform(15, 20, 2))
    sign = 1 if chance(rng, 0.6) else -1
    steepness = sign * np.tan([angles[0], 0, -angles[1]])
    kinks = np.concatenate([[0], np.cumsum(lengths)])
    levels = np.concatenate([[0], np.cumsum(lengths * steepness)])
    u, _ = site.turned(np.deg2rad(rng.uniform(-15, 15)))
    return Obstacle(np.interp(u + kinks[-1] / 2, kinks, levels), float(kinks[-1]))


def rough(rng: np.random.Generator, site: Site) -> Obstacle:
    """Noise of a few centimetres, from gravel to soft hills, up to 14 cm high and deep."""
    length = rng.uniform(2.6, 3.2)
    heights = ground.rough(rng, site)
    # Of the same roughness for every seed: what differs is how it is spread over wavelengths and places.
    heights *= rng.uniform(0.03, 0.04) / heights.std()
    return Obstacle(np.clip(heights, -0.14, 0.14) * fade(site, length, 0.25), length)
