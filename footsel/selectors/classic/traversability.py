"""ETH's traversability: the mean of slope, step and roughness.

M. Wermelinger, P. Fankhauser, R. Diethelm, P. Kruesi, R. Siegwart and M. Hutter, "Navigation Planning for Legged Robots
in Challenging Terrain", IEEE/RSJ International Conference on Intelligent Robots and Systems (IROS), 2016,
pp. 1184-1189; parameters of its public implementation, leggedrobotics/traversability_estimation
(`robot_filter_parameter.yaml`).

Taken: each of the three is worth 1 on flat ground and falls linearly to 0 at its critical value; traversability is
their mean. Slope: angle of the surface normal within a radius. Step: the range of heights in a first window; of these
ranges the largest in a second window, times the number of those beyond critical over a critical number, if that is
less than one. Roughness: standard deviation of the distances to the plane. Adapted: normals are those of the
least-squares plane in height, not of principal components; and a cell at which one of the three is critical may not be
chosen, where the original leaves that to its planner.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.selectors.classic.neighbourhood import Neighbourhood, disc, shifted
from footsel.selectors.classic.scorer import Judgement, TerrainScorer

CRITICAL_SLOPE = 1.0  # [rad]
CRITICAL_STEP = 0.12  # [m]
CRITICAL_ROUGHNESS = 0.05  # [m]
#: Of the windows for slope and roughness, and of both windows for steps. [m]
PLANE_RADIUS = 0.05
STEP_RADIUS = 0.04
#: So many steps beyond critical in the second window make it count in full.
CRITICAL_CELLS = 4


class Traversability(TerrainScorer):
    """Cost: one minus traversability."""

    def judge(self, heights: NDArray[np.float64], resolution: float) -> Judgement:
        plane = Neighbourhood(heights, PLANE_RADIUS, resolution).plane()
        measures = {
            "of critical slope": plane.inclination / CRITICAL_SLOPE,
            "at a critical step": _steps(heights, resolution) / CRITICAL_STEP,
            "of critical roughness": plane.roughness / CRITICAL_ROUGHNESS,
        }
        return Judgement(
            np.minimum(list(measures.values()), 1.0).mean(axis=0),
            {what: measure >= 1.0 for what, measure in measures.items()},
        )


def _steps(heights: NDArray[np.float64], resolution: float) -> NDArray[np.float64]:
    """(n, n) step height at each cell, in [m]."""
    window = Neighbourhood(heights, STEP_RADIUS, resolution)
    ranges = shifted(window.highest() - window.lowest(), disc(STEP_RADIUS, resolution))
    critical = (ranges > CRITICAL_STEP).sum(axis=0)
    return np.asarray(np.fmax.reduce(ranges, axis=0) * np.minimum(critical / CRITICAL_CELLS, 1.0))
