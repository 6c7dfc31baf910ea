"""The probability that a cell supports a foot, given that heights are uncertain.

C.-H. Chen and V. Kumar, "Motion Planning of Walking Robots in Environments with Uncertainty", IEEE International
Conference on Robotics and Automation (ICRA), 1996, pp. 3277-3282. The paper's source cites the two authors by the key
Chen2009 without a list of references; we take this to be the work that it means.

Taken, from the paper's account of it: the terrain becomes a map of the probability that each cell provides stable
support. Adapted, how that is computed: heights have independent normal errors of one size; a neighbour holds the foot
if its true height is within BAND of the cell's; an unknown one holds nothing. The foot is supported if it is held in
front, behind, left and right, each with the mean probability of that half of its surroundings, so the result does not
depend on the size of the cells. A cell that is more likely to give way than to hold is refused.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from footsel.selectors.classic.neighbourhood import Neighbourhood
from footsel.selectors.classic.scorer import Judgement, TerrainScorer

#: The foot's radius and a cell of 2 cm around it. [m]
RADIUS = 0.05
#: Error of a height: between that of a depth camera at 1 m (4 mm) and at 2 m (14 mm). [m]
HEIGHT_ERROR = 0.01
#: A foot's radius and a height's error: what lies lower is not touched, what lies higher is an obstacle. [m]
BAND = 0.04
LEAST_PROBABILITY = 0.5


class ChenKumar(TerrainScorer):
    """Cost: one minus the probability of support, as a share of flat ground's."""

    def judge(self, heights: NDArray[np.float64], resolution: float) -> Judgement:
        window = Neighbourhood(heights, RADIUS, resolution)
        holds = np.zeros(window.rise.shape)
        holds[window.known] = _within_band(window.rise[window.known])
        x, y = window.offsets.T
        halves = np.stack([x > 0, x < 0, y > 0, y < 0]).astype(np.float64)
        cells = np.tensordot(halves, window.inside().astype(np.float64), axes=1)
        support = (np.tensordot(halves, holds, axes=1) / np.maximum(cells, 1.0)).prod(axis=0)
        flat = float(_within_band(np.zeros(1))[0]) ** len(halves)
        return Judgement(
            np.maximum(1.0 - support / flat, 0.0),
            {"unlikely to support a foot": support < LEAST_PROBABILITY},
        )


def _within_band(rise: NDArray[np.float64]) -> NDArray[np.float64]:
    """Probability that two heights measured `rise` apart truly lie within BAND of each other."""
    error = np.sqrt(2.0) * HEIGHT_ERROR
    return np.asarray(ndtr((BAND - rise) / error) - ndtr((-BAND - rise) / error))
