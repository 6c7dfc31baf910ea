"""Credibility of the elevation, mean height and height variance around a foot point.

A. Roennau, T. Kerscher, M. Ziegenmeyer, J. M. Zoellner and R. Dillmann, "Six-Legged Walking in Rough Terrain Based on
Foot Point Planning", in Mobile Robotics: Solutions and Challenges (CLAWAR 2009), World Scientific, 2010, pp. 591-598.

Taken: foot points around the initial one are assessed by the credibility of the cells' elevation, the cells' mean
height and the variance of their heights. Adapted: LAURON's map keeps a credibility per cell and ours does not, so
credibility is the share of the window that is known, and half of it is required; the mean height counts by how far
the cell lies from it, on a bump or in a dip; the variance counts by its root. The scales are ours.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.selectors.classic.neighbourhood import Neighbourhood
from footsel.selectors.classic.scorer import Judgement, TerrainScorer

#: The foot's radius and a cell of 2 cm around it, rounded up. [m]
RADIUS = 0.06
#: Differences that cost all they can: a foot's radius, and the spread of a 53 degree slope over the window. [m]
FROM_MEAN = 0.03
DEVIATION = 0.04
LEAST_CREDIBILITY = 0.5


class Roennau(TerrainScorer):
    """Cost `1 - credibility * evenness`, evenness being one minus the mean of the two differences over their scales."""

    def judge(self, heights: NDArray[np.float64], resolution: float) -> Judgement:
        window = Neighbourhood(heights, RADIUS, resolution)
        credibility = window.known_share()
        differences = [np.abs(window.mean()) / FROM_MEAN, window.deviation() / DEVIATION]
        evenness = 1.0 - np.minimum(differences, 1.0).mean(axis=0)
        return Judgement(
            1.0 - credibility * evenness,
            {"of little credibility": credibility < LEAST_CREDIBILITY},
        )
