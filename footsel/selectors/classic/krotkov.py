"""Inclination, roughness and curvature of the ground under the foot, weighed by one sigmoid unit.

E. Krotkov and R. Simmons, "Perception, Planning, and Control for Autonomous Walking With the Ambler Planetary Rover",
The International Journal of Robotics Research 15(2), 1996, pp. 155-180.

Taken: the three features of the elevation map under a footprint, given to a simple neural network whose output is the
goodness of the foothold; it ranks footholds and rejects none. Adapted: the original network was trained on footholds
that experts had labelled for the Ambler's 30 cm feet. We have neither, so ours is a single sigmoid unit with stated
weights and bias: each feature alone brings it to one half at the value below, and flat ground is counted as 0. The
features are those of a least-squares plane and a paraboloid above it; ridge and bowl count alike.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from footsel.selectors.classic.neighbourhood import Neighbourhood
from footsel.selectors.classic.scorer import Judgement, TerrainScorer

#: The footprint: ANYmal's foot radius and a cell of 2 cm around it, rounded up. [m]
RADIUS = 0.06
#: Inverse weights. A quarter of a right angle; two thirds of the foot's radius; a dome as wide as three feet.
INCLINATION = float(np.pi / 4)  # [rad]
ROUGHNESS = 0.02  # [m]
CURVATURE = 10.0  # [1 / m]
#: Steepness of the unit: flat ground comes to 0.02 before that is taken off.
GAIN = 4.0


class Krotkov(TerrainScorer):
    """Cost: a sigmoid of inclination, roughness and |curvature|, each over its scale."""

    def judge(self, heights: NDArray[np.float64], resolution: float) -> Judgement:
        window = Neighbourhood(heights, RADIUS, resolution)
        plane = window.plane()
        inputs = (
            plane.inclination / INCLINATION + plane.roughness / ROUGHNESS + np.abs(window.curvature(plane)) / CURVATURE
        )
        flat = expit(-GAIN)
        return Judgement((expit(GAIN * (inputs - 1.0)) - flat) / (1.0 - flat))
