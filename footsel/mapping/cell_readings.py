"""What one depth image says of each cell: a height and how sure it is."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from footsel.mapping.camera import CameraModel
from footsel.mapping.config import MappingConfig
from footsel.mapping.grid import Grid


@dataclass(frozen=True, eq=False)
class CellReadings:
    """cells: (m,) flat indices, rising. height: (m,) in [m]. variance: (m,) of its errors, in [m^2].

    lasting: (m,) the part of the variance that images soon after one another share, in [m^2].
    """

    cells: NDArray[np.intp]
    height: NDArray[np.float64]
    variance: NDArray[np.float64]
    lasting: NDArray[np.float64]


class _Averages(NamedTuple):
    """Of the readings in each cell, all (size,).

    number: of readings. mean: weighted by 1 / variance, 0 without readings. weight: sum of the weights.
    excess: how much more they spread than their variances say, about 1 for one surface.
    """

    number: NDArray[np.float64]
    mean: NDArray[np.float64]
    weight: NDArray[np.float64]
    excess: NDArray[np.float64]

    @classmethod
    def of(
        cls, cells: NDArray[np.intp], heights: NDArray[np.floating], variances: NDArray[np.floating], size: int
    ) -> "_Averages":
        weights = 1 / variances
        number, weight, total = (_sums(cells, each, size) for each in (None, weights, weights * heights))
        mean: NDArray[np.float64] = np.divide(total, weight, out=np.zeros(size), where=weight > 0)
        squares = _sums(cells, weights * (heights - mean[cells]) ** 2, size)
        return cls(number, mean, weight, squares / np.maximum(number - 1, 1))


def _sums(cells: NDArray[np.intp], values: NDArray[np.floating] | None, size: int) -> NDArray[np.float64]:
    """(size,) of the values in each cell, or their number."""
    return np.asarray(np.bincount(cells, values, size), dtype=np.float64)


def read_cells(
    depth: NDArray[np.float32],
    camera: CameraModel,
    world_camera: NDArray[np.float64],
    grid: Grid,
    config: MappingConfig,
    doubted: NDArray[np.float64],
) -> CellReadings:
    """The uppermost surface in each cell that an image shows, with the camera's noise as its variance.

    depth: (height, width), 0 is no reading, in [m]. world_camera: (4, 4) placement of the camera's frame in W.
    doubted: (cells^2,) heights at which no reading counts, as other images look past them; NaN elsewhere, in [m].

    A pixel is a direction that is known and a depth that is not. Where the depth is off by e, the reading is e d_z too
    high and e d_h too far, d_z and d_h being how much the ray rises and how far it goes per metre of depth. On ground
    of slope m that is an error of height of `e (d_z - m d_h)`, of variance `sigma^2 (d_z^2 + slope^2 d_h^2)` for slopes
    of that size; readings anywhere in a cell add `slope^2 resolution^2 / 6`.

    The readings of a cell are averaged by these variances. Where they spread too much for one surface, those far below
    the highest are left out first. Where they still spread more than the variances say, the mean is taken to be the
    worse by as much (Birge's ratio).
    """
    seen = np.flatnonzero(depth)
    z = depth.reshape(-1)[seen]
    # Single precision is enough beside the camera: heights are good to micrometres.
    directions = world_camera[:3, :3].astype(np.float32) @ camera.rays[:, seen]
    x, y = directions[:2] * z + (world_camera[:2, 3] - grid.corner).astype(np.float32)[:, None]
    on_map = (x >= 0) & (y >= 0) & (x < grid.side) & (y < grid.side)
    cells = grid.cells_at(x[on_map], y[on_map])
    z, directions = z[on_map], directions[:, on_map]
    heights = z * directions[2]
    steepness = np.array([config.slope, config.slope, 1], dtype=np.float32) ** 2 @ directions**2
    variances = camera.noise.sigma(z) ** 2 * steepness + np.float32((config.slope * config.resolution) ** 2 / 6)
    counts = np.abs(heights - (doubted[cells] - world_camera[2, 3])) > config.gate * np.sqrt(2 * variances)
    counts |= np.isnan(doubted[cells])
    cells, heights, variances = cells[counts], heights[counts], variances[counts]

    readings = _Averages.of(cells, heights, variances, grid.cells**2)
    several = readings.excess > config.spread**2
    if several.any():
        among = np.flatnonzero(several[cells])
        kept = among[_uppermost(cells[among], heights[among], variances[among], config.gate, grid.cells**2)]
        upper = _Averages.of(cells[kept], heights[kept], variances[kept], grid.cells**2)
        readings = _Averages(*(np.where(several, *pair) for pair in zip(upper, readings, strict=True)))
    touched = np.flatnonzero(readings.number)
    number, mean, weight, excess = (values[touched] for values in readings)
    independent = np.maximum(number / camera.shared_px**2, 1)
    variance = number / weight / independent * np.maximum(excess, 1)
    return CellReadings(touched, mean + world_camera[2, 3], variance, np.zeros(len(touched)))


def _uppermost(
    cells: NDArray[np.intp], heights: NDArray[np.floating], variances: NDArray[np.floating], gate: float, size: int
) -> NDArray[np.bool_]:
    """(k,) which readings may be of the same surface as the highest in their cell."""
    highest = np.full(size, -np.inf, dtype=heights.dtype)
    np.maximum.at(highest, cells, heights)
    # The difference of two readings has twice the variance of one.
    return np.asarray(highest[cells] - heights <= gate * np.sqrt(2 * variances))
