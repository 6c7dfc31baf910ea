"""The fifth constraint: how risky the terrain around a cell is, c_m in [0, 1].

Belter and Skrzypczynski (2011) judge a foothold by two features of its 3x3 neighbourhood: K1 = sum(h0 - h), signed
(ridge > 0, pit < 0), and K2 = sum|h0 - h|. Here both are divided by six cell sides, so that they are slopes: a plane of
slope t along an axis has K2 = t and K1 = 0 at any cell size. The cost is one minus a Gaussian over (K1, K2) with its
peak at flat ground.

This is the first version, with widths chosen by hand so that the cost never falls with slope, the upper edge of a step
costs more than its foot, and a 3 cm edge costs more than 0.5. It is to be replaced by one fitted to simulated slippage.
"""

import numba
import numpy as np
from numpy.typing import NDArray

#: Width of the Gaussian over K2: a plane of 30 degrees costs 0.29, one of 45 degrees 0.64. [slope]
SLOPE_WIDTH = 0.7
#: Widths over K1: on ridges and upper edges the foot slips off; in pits and at the foot of a step it is caught. [slope]
RIDGE_WIDTH = 0.5
PIT_WIDTH = 1.0


def terrain_costs(heights: NDArray[np.floating], resolution: float) -> NDArray[np.float64]:
    """(n, n) c_m of every known cell, NaN where unknown. Missing neighbours, those beyond the map included, raise it.

    heights: (n, n) in [m], NaN = unknown.
    """
    return _terrain_costs(np.ascontiguousarray(heights, dtype=np.float64), resolution)


@numba.njit(cache=True)
def _terrain_costs(
    heights: NDArray[np.float64], resolution: float
) -> NDArray[np.float64]:  # pragma: no cover - compiled
    rows, columns = heights.shape
    costs = np.full((rows, columns), np.nan)
    for i in range(rows):
        for j in range(columns):
            centre = heights[i, j]
            if np.isnan(centre):
                continue
            signed, absolute, known = 0.0, 0.0, 0
            for ni in range(max(i - 1, 0), min(i + 2, rows)):
                for nj in range(max(j - 1, 0), min(j + 2, columns)):
                    height = heights[ni, nj]
                    if (ni == i and nj == j) or np.isnan(height):
                        continue
                    signed += centre - height
                    absolute += abs(centre - height)
                    known += 1
            if known == 0:
                costs[i, j] = 1.0
                continue
            scale = 8.0 / known / (6.0 * resolution)
            k1, k2 = signed * scale, absolute * scale
            width = RIDGE_WIDTH if k1 > 0.0 else PIT_WIDTH
            good = np.exp(-0.5 * (k2 / SLOPE_WIDTH) ** 2 - 0.5 * (k1 / width) ** 2)
            costs[i, j] = 1.0 - good * known / 8.0
    return costs
