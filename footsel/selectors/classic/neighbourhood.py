"""The ground around every cell of a map, within a radius fixed in metres: extremes, directions, plane, curvature.

Arrays hold the k neighbours first, (k, n, n), so that every feature is a reduction along the first axis over the whole
map. Unknown neighbours, those beyond the map included, are NaN and take part in nothing.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: A window holds at least the four nearest neighbours, however coarse the cells are.
SMALLEST_RADIUS_CELLS = 1.001
DIRECTIONS = 8
#: The least share of its greatest possible determinant that tells a scatter of known cells from a line.
SCATTER = 1e-6


@lru_cache(maxsize=64)
def disc(radius: float, resolution: float) -> NDArray[np.intp]:
    """(k, 2) steps in cells from a cell to those whose centres lie within `radius`, its own included."""
    reach = max(radius / resolution, SMALLEST_RADIUS_CELLS)
    along = np.arange(-int(reach), int(reach) + 1)
    steps = np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1).reshape(-1, 2)
    # A hair more than the radius: centres that lie on the circle belong to it, whatever the rounding.
    return steps[np.hypot(steps[:, 0], steps[:, 1]) <= reach + 1e-6].astype(np.intp)


def shifted(values: Array, steps: NDArray[np.intp]) -> Array:
    """(k, n, n) the value `steps` (k, 2) cells away from each cell; NaN beyond the map."""
    reach = int(np.abs(steps).max())
    rows, columns = values.shape
    padded = np.pad(values, reach, constant_values=np.nan)
    return np.stack([padded[reach + i : reach + i + rows, reach + j : reach + j + columns] for i, j in steps.tolist()])


@dataclass(frozen=True, eq=False)
class Plane:
    """Least-squares plane through the known cells of each window.

    gradient: (2, n, n) along x and y, NaN where the known cells lie on a line.
    residual: (k, n, n) height of each cell above the plane, 0 where unknown, in [m].
    roughness: (n, n) standard deviation of the cells' distances along the plane's normal, in [m].
    """

    gradient: Array
    residual: Array
    roughness: Array

    @property
    def inclination(self) -> Array:
        """(n, n) angle between the plane's normal and the vertical, in [rad]."""
        return np.asarray(np.arctan(np.hypot(self.gradient[0], self.gradient[1])))


class Neighbourhood:
    """Windows around all cells of a map.

    heights: (n, n) in [m], NaN = unknown. radius: of the window, in [m]. resolution: side of a cell, in [m].
    """

    def __init__(self, heights: Array, radius: float, resolution: float) -> None:
        steps = disc(radius, resolution)
        #: (k, 2) horizontal offsets of the neighbours, in [m].
        self.offsets: Array = steps.astype(np.float64) * resolution
        #: (k, n, n) height of each neighbour above the window's centre; NaN if either is unknown. [m]
        self.rise: Array = shifted(heights, steps) - heights
        self.known = ~np.isnan(self.rise)
        self._steps = steps

    def inside(self) -> NDArray[np.bool_]:
        """(k, n, n) which neighbours lie on the map. What lies beyond a local map is not ground that nobody saw."""
        return np.asarray(shifted(np.zeros(self.rise.shape[1:]), self._steps) == 0.0)

    def known_share(self) -> Array:
        """(n, n) share of the window's cells on the map that are known."""
        return np.asarray(self.known.sum(axis=0) / self.inside().sum(axis=0))

    def highest(self) -> Array:
        """(n, n) how far the window rises above its centre; 0 or more, NaN where the centre is unknown. [m]"""
        return np.asarray(np.fmax.reduce(self.rise, axis=0))

    def lowest(self) -> Array:
        """(n, n) how far the window falls below its centre, as a height: 0 or less. [m]"""
        return np.asarray(np.fmin.reduce(self.rise, axis=0))

    def mean(self) -> Array:
        """(n, n) mean height of the window above its centre. [m]"""
        return np.asarray(np.nan_to_num(self.rise).sum(axis=0) / self._count())

    def deviation(self) -> Array:
        """(n, n) standard deviation of the window's heights. [m]"""
        rise = np.nan_to_num(self.rise)
        variance = (rise**2).sum(axis=0) / self._count() - self.mean() ** 2
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    def directions(self, values: Array) -> Array:
        """(8, n, n) mean of `values` (k, n, n) over the known cells of eight wedges around the centre; NaN for none.

        The first wedge is centred on +x, the others follow at 45 degrees each towards +y. Two opposite ones are four
        apart. No cell's centre lies on a border between wedges: the tangent of 22.5 degrees is irrational.
        """
        angle = np.arctan2(self.offsets[:, 1], self.offsets[:, 0])
        wedge = np.round(angle / (2 * np.pi / DIRECTIONS)).astype(np.intp) % DIRECTIONS
        around = (self.offsets != 0.0).any(axis=1)
        member = ((wedge == np.arange(DIRECTIONS)[:, None]) & around).astype(np.float64)
        total = np.tensordot(member, np.where(self.known, values, 0.0), axes=1)
        count = np.tensordot(member, self.known.astype(np.float64), axes=1)
        return np.asarray(np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0))

    def plane(self) -> Plane:
        """The plane of each window."""
        gradient, residual = self._fit_plane(np.nan_to_num(self.rise))
        freedom = np.maximum(self.known.sum(axis=0) - 1, 1)
        vertical = np.sqrt((residual**2).sum(axis=0) / freedom)
        return Plane(gradient, residual, vertical / np.sqrt(1.0 + (gradient**2).sum(axis=0)))

    def curvature(self, plane: Plane) -> Array:
        """(n, n) curvature 2c of the surface `plane + c r^2` that fits best: above 0 in a bowl. [1 / m]

        What of r^2 no plane explains is regressed on the heights above the plane, which gives the same c as fitting
        all four coefficients at once (theorem of Frisch, Waugh and Lovell).
        """
        square = np.broadcast_to((self.offsets**2).sum(axis=1)[:, None, None], self.rise.shape)
        _, left = self._fit_plane(np.where(self.known, square, 0.0))
        weight = (left**2).sum(axis=0)
        product = (left * plane.residual).sum(axis=0)
        enough = weight > SCATTER * float((self.offsets**2).sum()) ** 2
        return np.asarray(2.0 * np.divide(product, weight, out=np.full_like(product, np.nan), where=enough))

    def _count(self) -> Array:
        """(n, n) known cells of the window; NaN if there is none, so that means are NaN too."""
        count = self.known.sum(axis=0)
        return np.asarray(np.where(count > 0, count, np.nan), dtype=np.float64)

    def _fit_plane(self, values: Array) -> tuple[Array, Array]:
        """(2, n, n) gradient and (k, n, n) residual of `values` (k, n, n), which are 0 where unknown."""
        x, y = self.offsets.T
        weights = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])
        n, sx, sy, sxx, sxy, syy = np.tensordot(weights, self.known.astype(np.float64), axes=1)
        sz, sxz, syz = np.tensordot(weights[:3], values, axes=1)
        n = np.maximum(n, 1.0)
        sxx, sxy, syy = sxx - sx * sx / n, sxy - sx * sy / n, syy - sy * sy / n
        sxz, syz = sxz - sx * sz / n, syz - sy * sz / n
        determinant = sxx * syy - sxy**2
        determinant[determinant <= SCATTER * (sxx + syy) ** 2] = np.nan
        gradient = np.stack([syy * sxz - sxy * syz, sxx * syz - sxy * sxz]) / determinant
        level = (sz - gradient[0] * sx - gradient[1] * sy) / n
        fitted = level + np.tensordot(self.offsets, gradient, axes=1)
        return gradient, np.where(self.known, values - fitted, 0.0)
