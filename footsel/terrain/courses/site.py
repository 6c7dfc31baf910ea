"""The square site that a course is laid out on, and the few tools that all families share.

Lengths are in metres and nothing is drawn per cell, so the same seed gives the same course at any cell size.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Height of a thing's top at offsets (dx, dy) from its middle, NaN beside it, in [m].
Top = Callable[[Array, Array], Array]
#: Lays out one course: heights (n, n) of the site's cells, in [m].
Family = Callable[[np.random.Generator, "Site"], Array]


@dataclass(frozen=True, eq=False)
class Site:
    """A square grid of cell centres around the origin.

    cells: number of cells along one side.
    resolution: side of a cell, in [m].
    x, y: (n, n) cell centres, in [m].
    """

    cells: int
    resolution: float
    x: Array = field(init=False, repr=False)
    y: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        along = (np.arange(self.cells) - (self.cells - 1) / 2) * self.resolution
        x, y = np.meshgrid(along, along, indexing="ij")
        object.__setattr__(self, "x", x)
        object.__setattr__(self, "y", y)

    @property
    def size(self) -> float:
        """Side of the site, in [m]."""
        return self.cells * self.resolution

    @property
    def reach(self) -> float:
        """Distance from the centre to a corner: how far a coordinate of any direction goes, in [m]."""
        return self.size / float(np.sqrt(2))

    def turned(self, yaw: float) -> tuple[Array, Array]:
        """(n, n) coordinates u along the direction `yaw` and v to its left, in [m]."""
        c, s = np.cos(yaw), np.sin(yaw)
        return c * self.x + s * self.y, c * self.y - s * self.x

    def flat(self) -> Array:
        """(n, n) zeros."""
        return np.zeros((self.cells, self.cells))

    def tilted(self, rng: np.random.Generator, slope: float) -> Array:
        """(n, n) a plane through the centre that rises by `slope` [m/m] in a random direction."""
        return np.asarray(slope * self.turned(any_direction(rng))[0])

    def noise(self, rng: np.random.Generator, wavelength: float) -> Array:
        """(n, n) smooth noise of unit variance without detail finer than about `wavelength` [m].

        Random heights on a lattice of half the wavelength, interpolated by the uniform cubic B-spline.
        """
        spacing = wavelength / 2
        knots = int(np.ceil(self.size / spacing)) + 4
        at = (np.arange(self.cells) + 0.5) * self.resolution / spacing + 1
        taps = np.floor(at).astype(np.intp)[:, None] + np.arange(-1, 3)
        distance = np.abs(at[:, None] - taps)
        basis = np.where(distance < 1, 2 / 3 - distance**2 + distance**3 / 2, np.maximum(2 - distance, 0) ** 3 / 6)
        # einsum and no matrix product: the sum's order must not depend on the threads of a BLAS.
        rows = np.einsum("it,itk->ik", basis, rng.standard_normal((knots, knots))[taps])
        heights = np.einsum("jt,ijt->ij", basis, rows[:, taps])
        # Mean square of the weights along one axis: the B-spline's autocorrelation at lag 0, 151/315.
        return np.asarray(heights / (151 / 315))

    def any_place(self, rng: np.random.Generator) -> tuple[float, float]:
        """A point of the site, all equally likely, in [m]."""
        x, y = rng.uniform(-self.size / 2, self.size / 2, 2).tolist()
        return x, y

    def height_at(self, heights: Array, x: float, y: float) -> float:
        """Height of the cell that the point (x, y) lies in, in [m]."""
        i, j = (min(max(int(c / self.resolution + self.cells / 2), 0), self.cells - 1) for c in (x, y))
        return float(heights[i, j])

    def stamp(self, heights: Array, x: float, y: float, radius: float, top: Top) -> None:
        """Raise `heights` in place to the top of a thing of this `radius` at (x, y), in [m]."""
        rows, columns = self._around(x, radius), self._around(y, radius)
        dx, dy = self.x[rows, columns] - x, self.y[rows, columns] - y
        part = heights[rows, columns]
        heights[rows, columns] = np.fmax(part, top(dx, dy))  # fmax passes over NaN.

    def _around(self, centre: float, radius: float) -> slice:
        middle = centre / self.resolution + (self.cells - 1) / 2
        reach = radius / self.resolution
        return slice(max(int(np.ceil(middle - reach)), 0), max(int(np.floor(middle + reach)) + 1, 0))


def any_direction(rng: np.random.Generator) -> float:
    """A direction in the plane, all equally likely, in [rad]."""
    return float(rng.uniform(-np.pi, np.pi))


def chance(rng: np.random.Generator, probability: float) -> bool:
    """True with this probability."""
    return bool(rng.random() < probability)


def lengths_to_cover(rng: np.random.Generator, low: float, high: float, site: Site) -> Array:
    """Edges (k,) along a direction, `low` to `high` [m] apart, that cover the site whatever the direction."""
    count = int(2 * (site.reach + high) / low) + 2
    start = -site.reach - rng.uniform(0, high)
    edges = np.cumsum(np.concatenate([[start], rng.uniform(low, high, count)]))
    return edges[: np.searchsorted(edges, site.reach) + 1]


def bounded_walk(changes: Array, bound: float) -> Array:
    """Levels (k + 1,) that start at 0 and change by the size of each `changes` (k,), turning back at +-`bound`."""
    levels = [0.0]
    for change in changes.tolist():
        level = levels[-1] + change
        levels.append(level if abs(level) <= bound else levels[-1] - change)
    return np.array(levels)


def gentle_ground(rng: np.random.Generator, site: Site) -> Array:
    """(n, n) ground for obstacles to stand on: level in half of the courses, else a slight slope, a little uneven."""
    if chance(rng, 0.5):
        return site.flat()
    uneven = rng.uniform(0, 0.006) * site.noise(rng, rng.uniform(0.1, 0.4))
    return site.tilted(rng, rng.uniform(0, np.tan(np.deg2rad(8)))) + uneven
