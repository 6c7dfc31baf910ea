"""Labelled maps as a robot would know them: its sensor's noise and holes in the input, the labels of the true map."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from footsel.dataset.samples import Samples, encode_heights
from footsel.errors import InputError, UnknownNameError
from footsel.footholds import Reason
from footsel.footholds.cost import INFEASIBLE_COST
from footsel.terrain.degradation import depth_camera_reading, lose_cells

NOISES = ("none", "d435")


@dataclass(frozen=True)
class Degradation:
    """What is done to the input of a network that is judged.

    noise: "none", or "d435" (footsel.terrain.degradation.depth_camera_reading). holes: share of each map's cells that
    becomes unknown. seed: of both.

    Raises UnknownNameError for another noise, InputError for a share out of [0, 1).
    """

    noise: str = "none"
    holes: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        if self.noise not in NOISES:
            raise UnknownNameError("noise", self.noise, NOISES)
        if not 0 <= self.holes < 1:
            raise InputError(f"the share of holes is {self.holes}", "give 0 or more and less than 1")


def degraded(samples: Samples, degradation: Degradation, resolution: float, first: int = 0) -> Samples:
    """The same maps and labels with degraded heights; cells that become unknown lose their label too.

    Nothing is asked of a cell that the input does not know, but that it is never picked. All other labels remain those
    of the true map: noise that hides an obstacle makes an error, not an excuse.

    resolution: side of a cell, in [m]. first: number of the first map; each map's noise depends on the seed and its
    number alone.
    """
    heights = samples.heights()
    for index, true in enumerate(heights):
        rng = np.random.default_rng([degradation.seed, first + index])
        seen = depth_camera_reading(true, resolution, rng) if degradation.noise == "d435" else true
        heights[index] = lose_cells(seen, degradation.holes, rng)
    return with_heights(samples, heights)


def with_heights(samples: Samples, heights: NDArray[np.float32]) -> Samples:
    """The samples with other heights (n, 40, 40), in [m]; what is unknown in them has no label."""
    unknown = np.isnan(heights)
    return replace(
        samples,
        heights_tenth_mm=encode_heights(heights),
        cost=np.where(unknown, np.uint8(INFEASIBLE_COST), samples.cost),
        reason=np.where(unknown, np.uint8(Reason.UNKNOWN), samples.reason),
    )
