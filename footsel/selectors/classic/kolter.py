"""A weighted sum of local features of the height map at four scales.

J. Z. Kolter, M. P. Rodgers and A. Y. Ng, "A Control Architecture for Quadruped Locomotion Over Rough Terrain", IEEE
International Conference on Robotics and Automation (ICRA), 2008, pp. 811-818; the features come from J. Z. Kolter,
P. Abbeel and A. Y. Ng, "Hierarchical Apprenticeship Learning with Application to Quadruped Locomotion", NIPS 20, 2007,
pp. 769-776. M. Kalakrishnan, J. Buchli, P. Pastor and S. Schaal, "Learning Locomotion over Rough Terrain using Terrain
Templates", IROS 2009, pp. 167-172, belong to the same family, with learned templates in place of the features.

Taken: square windows of 5, 7, 11 and 21 cells around the foot, and in each the slopes along x and y, the greatest
height above the centre, the greatest depth below it and the standard deviation; a cost linear in these 20 features;
none is rejected. Adapted: the windows are fixed in metres, those that these counts make of 2 cm cells; signed slopes,
of use to weights learned per leg, are taken by their size. The original weights were learned from demonstrations with
LittleDog; ours are equal, each feature divided by its value on a plane of 45 degrees along an axis and held to 1.
The original's feature of collisions of the leg is left out: this scorer sees ground alone.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from footsel.selectors.classic.neighbourhood import SCATTER
from footsel.selectors.classic.scorer import Judgement, TerrainScorer

#: From the centre of a window to the centres of its outermost cells: 5, 7, 11 and 21 cells of 2 cm. [m]
HALF_WIDTHS = (0.04, 0.06, 0.10, 0.20)


class Kolter(TerrainScorer):
    """Cost: the mean of the 20 features."""

    def judge(self, heights: NDArray[np.float64], resolution: float) -> Judgement:
        sums = _Sums(heights, resolution)
        features = [feature for half_width in HALF_WIDTHS for feature in sums.features(half_width)]
        return Judgement(np.minimum(features, 1.0).mean(axis=0))


class _Sums:
    """Running sums over a map, from which the moments of any square window follow (summed-area tables)."""

    def __init__(self, heights: NDArray[np.float64], resolution: float) -> None:
        self._heights = heights
        self._resolution = resolution
        known = ~np.isnan(heights)
        rows, columns = heights.shape
        x = (np.arange(rows) - (rows - 1) / 2)[:, None] * resolution
        y = (np.arange(columns) - (columns - 1) / 2)[None, :] * resolution
        # Variances are differences of large sums: heights near 0 keep them exact.
        z = np.where(known, heights - (np.median(heights[known]) if known.any() else 0.0), 0.0)
        ones = known.astype(np.float64)
        terms = [ones, x * ones, y * ones, z, x * x * ones, x * y * ones, y * y * ones, x * z, y * z, z * z]
        self._table = np.pad(np.stack(terms).cumsum(axis=1).cumsum(axis=2), [(0, 0), (1, 0), (1, 0)])
        self._high = np.where(known, heights, -np.inf)
        self._low = np.where(known, heights, np.inf)

    def features(self, half_width: float) -> list[NDArray[np.float64]]:
        """|slope x|, |slope y|, rise, depth and deviation, (n, n) each, over their value on a plane of 45 degrees."""
        reach = max(int(half_width / self._resolution + 0.5), 1)
        slope_x, slope_y, deviation = self._moments(reach)
        side = 2 * reach + 1
        highest = maximum_filter(self._high, side, mode="constant", cval=-np.inf) - self._heights
        lowest = self._heights - minimum_filter(self._low, side, mode="constant", cval=np.inf)
        height = reach * self._resolution
        # Variance of `side` equally spaced numbers: (side^2 - 1) / 12.
        spread = self._resolution * np.sqrt((side**2 - 1) / 12)
        return [np.abs(slope_x), np.abs(slope_y), highest / height, lowest / height, deviation / spread]

    def _moments(self, reach: int) -> tuple[NDArray[np.float64], ...]:
        """Slope along x and y of the least-squares plane and standard deviation of the heights, (n, n) each."""
        rows, columns = self._heights.shape
        low_i, high_i = _bounds(rows, reach)
        low_j, high_j = _bounds(columns, reach)
        across = self._table[:, high_i] - self._table[:, low_i]
        count, sx, sy, sz, sxx, sxy, syy, sxz, syz, szz = across[:, :, high_j] - across[:, :, low_j]
        count = np.maximum(count, 1.0)
        sxx, sxy, syy = sxx - sx * sx / count, sxy - sx * sy / count, syy - sy * sy / count
        sxz, syz, szz = sxz - sx * sz / count, syz - sy * sz / count, szz - sz * sz / count
        determinant = sxx * syy - sxy**2
        determinant[determinant <= SCATTER * (sxx + syy + self._resolution**2) ** 2] = np.nan
        slope_x = (syy * sxz - sxy * syz) / determinant
        slope_y = (sxx * syz - sxy * sxz) / determinant
        return slope_x, slope_y, np.sqrt(np.maximum(szz / count, 0.0))


def _bounds(cells: int, reach: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First cell and end of each cell's window along an axis, cut at the map's border."""
    cell = np.arange(cells)
    return np.maximum(cell - reach, 0), np.minimum(cell + reach + 1, cells)
