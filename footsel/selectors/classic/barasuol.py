"""The acceptable cell nearest to the nominal foothold, by the pattern of the ground around it.

V. Barasuol, M. Camurri, S. Bazeille, D. G. Caldwell and C. Semini, "Reactive Trotting with Foot Placement Corrections
through Visual Pattern Classification", IEEE/RSJ International Conference on Intelligent Robots and Systems (IROS),
2015, pp. 5734-5741.

Taken: the pattern of a small height map around the nominal foothold is classified, and the foothold is moved to the
nearest place that is safe for foot and shin. Adapted: the original classifier is learned from patterns labelled for
HyQ. Ours is a rule: the ground in each of eight directions is higher, lower or level with the cell, once the slope
under the foot is taken away; a cell is acceptable if that slope is not too steep, all of the pattern but one direction
is level, and nothing around it rises against the shin. Every acceptable cell costs the same, so distance alone decides.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.selectors.classic.neighbourhood import Neighbourhood
from footsel.selectors.classic.scorer import Judgement, TerrainScorer

#: The foot's radius and a cell of 2 cm around it, rounded up; ground that the shin comes near. [m]
RADIUS = 0.06
SHIN_RADIUS = 0.10
#: A direction is level if its mean height is within this of the cell's: half a foot's radius. [m]
LEVEL = 0.015
#: One direction may be off, as noise or a pebble makes it.
OFF_LEVEL_DIRECTIONS = 1
SLOPE = float(np.deg2rad(35.0))  # [rad]
#: Rise within SHIN_RADIUS that a shin meets; more than the steepest slope makes. [m]
OBSTACLE = 0.08


class Barasuol(TerrainScorer):
    """No cost for an acceptable cell."""

    def judge(self, heights: NDArray[np.float64], resolution: float) -> Judgement:
        window = Neighbourhood(heights, RADIUS, resolution)
        plane = window.plane()
        slope = np.tensordot(window.offsets, plane.gradient, axes=1)
        # A direction of which nothing is known is not known to be level.
        level = np.abs(window.directions(window.rise - slope)) <= LEVEL
        rises = Neighbourhood(heights, SHIN_RADIUS, resolution).highest()
        return Judgement(
            np.where(np.isnan(plane.roughness), np.nan, 0.0),
            {
                "of uneven pattern": (~level).sum(axis=0) > OFF_LEVEL_DIRECTIONS,
                "on too steep a slope": plane.inclination > SLOPE,
                "against the shin": rises > OBSTACLE,
            },
        )
