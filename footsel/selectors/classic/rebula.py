"""Rejects edges, large slopes, the base of a cliff and the inside of a hole.

J. R. Rebula, P. D. Neuhaus, B. V. Bonnlander, M. J. Johnson and J. E. Pratt, "A Controller for the LittleDog Quadruped
Walking on Rough Terrain", IEEE International Conference on Robotics and Automation (ICRA), 2007, pp. 1467-1473.

Taken: the terrain scorer compares a point with the points around it and rejects it for these four. Adapted: the
original measures and thresholds belong to LittleDog and its small feet; those below are ours, chosen so that an even
slope that is accepted is never taken for an edge, a cliff or a hole. An accepted cell costs the square of how near it
comes to the nearest of its rejections, so ground that is far from all four is nearly free.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.selectors.classic.neighbourhood import Neighbourhood
from footsel.selectors.classic.scorer import Judgement, TerrainScorer

#: Ground under the foot and beside it; ground that the shank comes near. [m]
NEAR = 0.04
FAR = 0.10
#: Steepest slope: over NEAR it falls by 2.3 cm, over FAR it rises by 5.8 cm, less than the two limits below. [rad]
SLOPE = float(np.deg2rad(30.0))
#: Edge: the ground near the cell falls by more than this, most of a foot's radius. [m]
DROP = 0.025
#: Base of a cliff: the ground somewhere around the cell rises by more. [m]
CLIFF = 0.08
#: Inside of a hole: the ground in six of eight directions lies higher by more; a slope lifts five at most. [m]
HOLE = 0.02
HOLE_DIRECTIONS = 6


class Rebula(TerrainScorer):
    """Cost: the square of the largest of four measures over their limits, beyond which a cell is rejected."""

    def judge(self, heights: NDArray[np.float64], resolution: float) -> Judgement:
        near = Neighbourhood(heights, NEAR, resolution)
        far = Neighbourhood(heights, FAR, resolution)
        around = np.nan_to_num(far.directions(far.rise), nan=-np.inf)
        walled = np.sort(around, axis=0)[-HOLE_DIRECTIONS]
        measures = {
            "on an edge": -near.lowest() / DROP,
            "on too steep a slope": near.plane().inclination / SLOPE,
            "at the base of a cliff": far.highest() / CLIFF,
            "inside a hole": np.maximum(walled, 0.0) / HOLE,
        }
        return Judgement(
            np.maximum.reduce(list(measures.values())) ** 2,
            {what: measure > 1.0 for what, measure in measures.items()},
        )
