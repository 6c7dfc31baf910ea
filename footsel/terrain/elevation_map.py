"""A world-aligned elevation map and how it is sampled between its cells."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import MapError


@dataclass(frozen=True, eq=False)
class ElevationMap:
    """Terrain height on a regular grid of the world frame W.

    elevation: (nx, ny) float32 height of each cell, i along +x and j along +y, NaN = unknown, in [m].
    resolution: side of a cell, in [m].
    position: (2,) world xy of the map's centre, in [m].

    Cell (i, j) has its centre at `position + ((i, j) - (n - 1) / 2) * resolution`.
    A map may be wholly unknown: footholds on it are then answered with "none".

    Raises MapError for another number of dimensions, infinite heights, or a resolution that is not positive.
    """

    elevation: NDArray[np.float32]
    resolution: float
    position: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))

    def __post_init__(self) -> None:
        try:
            if np.iscomplexobj(self.elevation):
                raise TypeError("complex heights")
            # Heights beyond float32 turn infinite in the cast and are refused below.
            with np.errstate(over="ignore"):
                elevation = np.ascontiguousarray(self.elevation, dtype=np.float32)
            resolution = float(self.resolution)
            position = np.asarray(self.position, dtype=np.float64).reshape(-1)
        except (TypeError, ValueError) as error:
            raise MapError(f"elevation map is not numeric ({error})", "give floats in metres") from None
        if elevation.ndim != 2 or min(elevation.shape) < 2:
            raise MapError(
                f"elevation has shape {elevation.shape}", "expected a 2-D array (nx, ny) of at least 2x2 cells"
            )
        if np.isinf(elevation).any():
            raise MapError("elevation holds infinite heights", "mark unknown cells with NaN")
        if not np.isfinite(resolution) or resolution <= 0:
            raise MapError(f"resolution is {resolution}", "expected a cell side above 0 m")
        if position.shape != (2,) or not np.isfinite(position).all():
            raise MapError(f"position is {position.tolist()}", "expected two finite numbers, world xy in metres")
        object.__setattr__(self, "elevation", elevation)
        object.__setattr__(self, "resolution", resolution)
        object.__setattr__(self, "position", position)

    @classmethod
    def load(cls, path: str | Path, **options: Any) -> "ElevationMap":
        """Read a map file; the suffix names the format and `options` are that format's (see terrain.formats.load)."""
        from footsel.terrain.formats import load

        return load(path, **options)

    def save(self, path: str | Path) -> None:
        """Write `.npz` with `elevation`, `resolution` and `position`."""
        from footsel.terrain.formats.npz import save

        save(self, path)

    @property
    def shape(self) -> tuple[int, int]:
        """(nx, ny) cells."""
        nx, ny = self.elevation.shape
        return nx, ny

    @property
    def size(self) -> tuple[float, float]:
        """(x, y) side lengths, borders of the outer cells included, in [m]."""
        nx, ny = self.shape
        return nx * self.resolution, ny * self.resolution

    @property
    def known(self) -> NDArray[np.bool_]:
        """(nx, ny) which cells have a height."""
        return ~np.isnan(self.elevation)

    def x(self) -> NDArray[np.float64]:
        """(nx,) world x of the cell centres, in [m]."""
        return self._along(0)

    def y(self) -> NDArray[np.float64]:
        """(ny,) world y of the cell centres, in [m]."""
        return self._along(1)

    def fractional_index(self, xy: ArrayLike) -> NDArray[np.float64]:
        """(..., 2) index of world points, whole numbers at cell centres."""
        centre = (np.array(self.shape) - 1) / 2
        return (np.asarray(xy, dtype=np.float64) - self.position) / self.resolution + centre

    def contains(self, xy: ArrayLike) -> NDArray[np.bool_]:
        """(...,) whether world points lie on the map, known or not."""
        index = self.fractional_index(xy)
        return np.asarray(((index >= -0.5) & (index < np.array(self.shape) - 0.5)).all(axis=-1))

    def sample(self, xy: ArrayLike) -> NDArray[np.float32]:
        """Heights at world points xy (..., 2), in [m]; NaN where the nearest cell is unknown or off the map.

        Heights are interpolated bilinearly, so a plane stays that plane at any yaw and any cell size. Unknown
        neighbours carry no weight. A point is known exactly if the cell that it falls in is known: holes
        neither grow nor shrink.
        """
        nx, ny = self.shape
        index = self.fractional_index(xy)
        u, v = index[..., 0], index[..., 1]
        inside = (u + 0.5 >= 0) & (u + 0.5 < nx) & (v + 0.5 >= 0) & (v + 0.5 < ny)

        u, v = np.clip(u, 0, nx - 1), np.clip(v, 0, ny - 1)
        i, j = np.minimum(u.astype(np.intp), nx - 2), np.minimum(v.astype(np.intp), ny - 2)
        a, b = u - i, v - j
        # (4, ...) the cells around each point: (i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1).
        corners = i * ny + j + np.array([0, 1, ny, ny + 1]).reshape(4, *([1] * i.ndim))
        heights = self.elevation.reshape(-1)[corners]
        weights = np.stack([(1 - a) * (1 - b), (1 - a) * b, a * (1 - b), a * b])
        unknown = np.isnan(heights)
        if unknown.any():
            nearest = 2 * (np.floor(u + 0.5) > i) + (np.floor(v + 0.5) > j)
            inside &= ~np.take_along_axis(unknown, nearest[None], axis=0)[0]
            weights[unknown] = 0
            heights[unknown] = 0
        with np.errstate(invalid="ignore"):
            mean = (weights * heights).sum(axis=0) / weights.sum(axis=0)
        return np.where(inside, mean, np.nan).astype(np.float32)

    def window(self, centre: ArrayLike, cells: int) -> "ElevationMap":
        """The (cells, cells) part of the map around the cell nearest to world point `centre`; unknown off the map.

        `cells` is odd, so that the window has a middle cell.
        """
        half = cells // 2
        middle = np.floor(self.fractional_index(centre) + 0.5).astype(int)
        elevation = np.full((cells, cells), np.nan, dtype=np.float32)
        low = middle - half
        first = np.maximum(low, 0)
        last = np.minimum(low + cells, self.shape)
        if (last > first).all():
            inside = tuple(slice(a, b) for a, b in zip(first - low, last - low, strict=True))
            elevation[inside] = self.elevation[first[0] : last[0], first[1] : last[1]]
        offset = (middle - (np.array(self.shape) - 1) / 2) * self.resolution
        return ElevationMap(elevation, self.resolution, self.position + offset)

    def _along(self, axis: int) -> NDArray[np.float64]:
        cells = self.shape[axis]
        return np.asarray(self.position[axis] + (np.arange(cells) - (cells - 1) / 2) * self.resolution)
