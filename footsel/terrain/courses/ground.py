"""Ground without edges or with soft ones: flat, slopes, rough ground, bumps and concavities."""

import numpy as np

from footsel.terrain.courses.site import (
    Array,
    Site,
    Top,
    any_direction,
    bounded_walk,
    chance,
    gentle_ground,
    lengths_to_cover,
)

STEEPEST = np.tan(np.deg2rad(30))


def flat(rng: np.random.Generator, site: Site) -> Array:  # noqa: ARG001
    """Level ground at z = 0."""
    return site.flat()


def slopes(rng: np.random.Generator, site: Site) -> Array:
    """One plane of up to 30 degrees, or ramps that kink every 0.5 to 1.5 m, in one direction or two that cross."""
    kind = rng.random()
    if kind < 0.3:
        return site.tilted(rng, np.tan(np.deg2rad(rng.uniform(2, 30))))
    yaw = any_direction(rng)
    heights = _ramps(rng, site, yaw)
    if kind < 0.65:
        return heights
    # Two crossing sets of ramps: facets. Their slopes add like the sides of a right triangle.
    crossing = _ramps(rng, site, yaw + np.pi / 2)
    share = rng.uniform(0.3, 0.95)
    return np.asarray(share * heights + np.sqrt(1 - share**2) * crossing)


def rough(rng: np.random.Generator, site: Site) -> Array:
    """Noise from 8 cm to 0.8 m wide and up to about 10 cm high, calmer in some places than in others."""
    amplitude = rng.uniform(0.01, 0.045)
    # How fast the height of the noise falls with its width: small values are gravel, large ones are soft hills.
    smoothness = rng.uniform(0.4, 1.1)
    longest = rng.uniform(0.3, 0.8)
    heights = site.flat()
    power = 0.0
    wavelength = longest
    while wavelength > 0.08:
        weight = (wavelength / longest) ** smoothness
        heights += weight * site.noise(rng, wavelength)
        power += weight**2
        wavelength /= 2
    heights *= amplitude / np.sqrt(power)
    calm = rng.uniform(0.2, 0.9)
    roughness = calm + (1 - calm) / (1 + np.exp(-2 * site.noise(rng, 2.0)))
    return np.clip(heights * roughness, -0.14, 0.14)


def bumps(rng: np.random.Generator, site: Site) -> Array:
    """Spherical caps, bowls and steep pits of 10 cm to 0.9 m across, 3 to 25 cm high or deep, some inside others."""
    raised, sunken = site.flat(), site.flat()
    for _ in range(rng.poisson(rng.uniform(2.5, 5) * site.size**2)):
        x, y = site.any_place(rng)
        radius = rng.uniform(0.05, 0.45)
        height = min(rng.uniform(0.03, 0.25), 0.9 * radius)
        top = _spherical_cap(radius, height) if chance(rng, 0.75) else _drum(radius, height, rng.uniform(4, 12))
        site.stamp(raised if chance(rng, 0.5) else sunken, x, y, radius, top)
    return gentle_ground(rng, site) + raised - sunken


def _spherical_cap(radius: float, height: float) -> Top:
    """The cap of a sphere, `height` above its rim of this radius, in [m]."""
    sphere = (radius**2 + height**2) / (2 * height)

    def top(dx: Array, dy: Array) -> Array:
        return np.asarray(np.sqrt(np.maximum(sphere**2 - dx**2 - dy**2, 0)) - (sphere - height))

    return top


def _drum(radius: float, height: float, power: float) -> Top:
    """A round thing with a flat top and steep sides, steeper for a higher power, in [m]."""

    def top(dx: Array, dy: Array) -> Array:
        return height * (1 - ((dx**2 + dy**2) / radius**2) ** (power / 2))

    return top


def _ramps(rng: np.random.Generator, site: Site, yaw: float) -> Array:
    """(n, n) ramps along `yaw` of up to the steepest slope, each 0.5 to 1.5 m long, some of them level."""
    kinks = lengths_to_cover(rng, 0.5, 1.5, site)
    slope = rng.uniform(-STEEPEST, STEEPEST, len(kinks) - 1) * (rng.random(len(kinks) - 1) < 0.85)
    levels = bounded_walk(slope * np.diff(kinks), 0.5)
    heights = np.interp(site.turned(yaw)[0], kinks, levels)
    return np.asarray(heights - heights.mean())
