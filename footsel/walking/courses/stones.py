"""Crossing the stream on stepping stones."""

import numpy as np

from footsel.terrain.courses.site import Array, Site, Top, chance
from footsel.walking.courses.strip import HALF_WIDTH, Family, Obstacle

DEPTH = 0.5
#: Stones stand at least this far apart. [m]
NEAREST = 0.03
#: Tops are within this of the banks' height, and tilted by at most so much. [m], [m/m]
LEVEL, TILT = 0.05, float(np.tan(np.deg2rad(4)))


def stones(narrowest: float, widest: float, widest_gap: float) -> Family:
    """Stones of these widths at +-5 cm, at most `widest_gap` apart along the crossing, over a bed 0.5 m deep, in [m].

    They stand in columns across the stream, up to 10 degrees askew; each column has a pitch of its own and is shifted
    against the next. Stones are ellipses or blocks with rounded corners, no two of the same size.
    """

    def layout(rng: np.random.Generator, site: Site) -> Obstacle:
        pitches = _pitches(rng, rng.uniform(2.6, 2.9))
        borders = np.concatenate([[0], np.cumsum(pitches)]) - pitches.sum() / 2
        heading = np.deg2rad(rng.uniform(-10, 10))
        power = rng.uniform(2.5, 8) if chance(rng, 0.7) else 2.0
        u, _ = site.turned(heading)
        bed = -DEPTH + 0.01 * site.noise(rng, 0.4)
        heights = np.where((u < borders[0]) | (u >= borders[-1]), 0.0, np.minimum(bed, -DEPTH + 0.03))
        for middle, pitch in zip((borders[:-1] + borders[1:]) / 2, pitches, strict=True):
            _add_column(rng, site, heights, heading, middle, pitch, power)
        return Obstacle(heights, float(pitches.sum() / np.cos(heading)))

    def _pitches(rng: np.random.Generator, length: float) -> Array:
        """(k,) widths of columns that hold a stone and half a gap on each side, `length` in all or a little more."""
        drawn = rng.uniform(narrowest + NEAREST + 0.05, widest + 0.55 * widest_gap, 40)
        return drawn[: np.searchsorted(np.cumsum(drawn), length) + 1]

    def _sizes(rng: np.random.Generator, pitch: float, count: int) -> Array:
        """(count,) widths that leave no gap above the widest one and none below the narrowest."""
        return rng.uniform(max(narrowest, pitch - widest_gap), min(widest, pitch - NEAREST), count)

    def _add_column(
        rng: np.random.Generator, site: Site, heights: Array, heading: float, middle: float, pitch: float, power: float
    ) -> None:
        """Raise the stones of one column, its middle at `middle` along the crossing."""
        (across,) = _pitches(rng, 0.0)
        half = int((HALF_WIDTH + 0.6) / across) + 1
        rows = (np.arange(-half, half + 1) + rng.uniform(-0.5, 0.5)) * across
        length, width = _sizes(rng, pitch, len(rows)), _sizes(rng, across, len(rows))
        yaw = np.deg2rad(rng.uniform(-12, 12, len(rows)))
        wide = _extent(length, width, yaw, power), _extent(width, length, yaw, power)
        # A large stone fits into its place only straight.
        yaw[(wide[0] > pitch - NEAREST) | (wide[1] > across - NEAREST)] = 0
        du = _shift(rng, _extent(length, width, yaw, power), pitch)
        dv = _shift(rng, _extent(width, length, yaw, power), across)
        level = rng.uniform(-LEVEL, LEVEL, len(rows))
        tilt = TILT * rng.uniform(-1, 1, (len(rows), 2))
        # The highest and the lowest point of a top are within the bounds too.
        level *= 1 - (np.abs(tilt[:, 0]) * length + np.abs(tilt[:, 1]) * width) / 2 / LEVEL
        c, s = np.cos(heading), np.sin(heading)
        for k, (u, v) in enumerate(zip(middle + du, rows + dv, strict=True)):
            top = _top(length[k], width[k], heading + yaw[k], level[k], tilt[k], power)
            site.stamp(heights, c * u - s * v, s * u + c * v, 0.75 * max(length[k], width[k]), top)

    def _shift(rng: np.random.Generator, extent: Array, pitch: float) -> Array:
        """(k,) how far stones stand off the middle of their place: neighbours stay within both bounds of a gap."""
        most = np.minimum(widest_gap - pitch + extent, pitch - extent - NEAREST) / 2
        return rng.uniform(-1, 1, len(extent)) * most

    return layout


def _extent(along: Array, across: Array, yaw: Array, power: float) -> Array:
    """(k,) size of superellipses turned by `yaw` in the direction of their length, by the support function, in [m]."""
    dual = power / (power - 1)
    reach = (along * np.cos(yaw)) ** dual + np.abs(across * np.sin(yaw)) ** dual
    return np.asarray(reach ** (1 / dual))


def _top(length: float, width: float, yaw: float, level: float, tilt: Array, power: float) -> Top:
    """Top of a stone: an ellipse for power 2, a block with rounded corners for higher ones."""
    c, s = np.cos(yaw), np.sin(yaw)

    def top(dx: Array, dy: Array) -> Array:
        along, across = c * dx + s * dy, c * dy - s * dx
        outline = np.abs(along / (length / 2)) ** power + np.abs(across / (width / 2)) ** power
        return np.where(outline <= 1, level + tilt[0] * along + tilt[1] * across, np.nan)

    return top
