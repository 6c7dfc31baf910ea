"""The cells of a map that moves along with the robot, and keeps to whole cells of the world."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, eq=False)
class Grid:
    """cells: along each side. resolution: in [m]. middle: (2,) of the map, in whole cells from the world's origin."""

    cells: int
    resolution: float
    middle: NDArray[np.intp]

    @property
    def position(self) -> NDArray[np.float64]:
        """(2,) world xy of the map's centre, in [m]."""
        return np.asarray(self.middle * self.resolution, dtype=np.float64)

    @property
    def corner(self) -> NDArray[np.float64]:
        """(2,) world xy of the outer corner of cell (0, 0), in [m]."""
        return self.position - self.side / 2

    @property
    def side(self) -> float:
        """In [m]."""
        return self.cells * self.resolution

    def centred_on(self, xy: ArrayLike) -> "Grid":
        """The grid with its centre at the whole cell next to a world point."""
        middle = np.rint(np.asarray(xy, dtype=np.float64) / self.resolution).astype(np.intp)
        return Grid(self.cells, self.resolution, middle)

    def cells_at(self, x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.intp]:
        """(k,) flat indices of the cells that points fall in, given relative to `corner` and on the map, in [m]."""
        scale, last = np.float32(1 / self.resolution), self.cells - 1
        i, j = (np.minimum((along * scale).astype(np.intp), last) for along in (x, y))
        return np.asarray(i * self.cells + j)

    def centres(self, flat: NDArray[np.intp]) -> NDArray[np.float64]:
        """(k, 2) world xy of the centres of cells by flat index, in [m]."""
        index = np.stack(np.unravel_index(flat, (self.cells, self.cells)), axis=-1)
        return self.corner + (index + 0.5) * self.resolution


def moved(layer: NDArray[np.float64], shift: NDArray[np.intp], fill: float) -> NDArray[np.float64]:
    """A layer (n, n, ...) of the grid whose centre lies `shift` (2,) cells further; what is new holds `fill`."""
    n = len(layer)
    kept = np.full_like(layer, fill)
    if (np.abs(shift) < n).all():
        first, last = np.maximum(shift, 0), n + np.minimum(shift, 0)
        to_first, to_last = first - shift, last - shift
        kept[to_first[0] : to_last[0], to_first[1] : to_last[1]] = layer[first[0] : last[0], first[1] : last[1]]
    return kept
