"""Where the walker's elevation map comes from: all that it ever knows of the terrain."""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from footsel.terrain import ElevationMap


class MapSource(ABC):
    """Gives the elevation map that selector, planner and swing read; nobody else tells them about the ground."""

    #: Whether it may know more after another look.
    learns: bool = False

    @abstractmethod
    def update(self, time: float, base: NDArray[np.float64], joints: NDArray[np.float64]) -> None:
        """Take notice of the world at a time of the walk, called about ten times a second.

        time: in [s]. base: (4, 4) estimated placement of the base in W.
        joints: (12,) angles by LEGS and HAA HFE KFE, in [rad].
        """

    def feel(self, base: NDArray[np.float64], joints: NDArray[np.float64], foot_forces: NDArray[np.float64]) -> None:
        """Take notice of where the feet stand, called after `update`; a map that is given needs none of it.

        base, joints: as there. foot_forces: (4, 3) of the ground on each foot by LEGS, in W, in [N].
        """
        del base, joints, foot_forces

    @abstractmethod
    def elevation_map(self) -> ElevationMap:
        """The map as known now, in W; unknown cells are NaN."""


class GivenMap(MapSource):
    """A map known beforehand that nothing changes: `exact`, or a degraded copy, `noisy`."""

    def __init__(self, elevation_map: ElevationMap) -> None:
        self._elevation_map = elevation_map

    def update(self, time: float, base: NDArray[np.float64], joints: NDArray[np.float64]) -> None:
        """Nothing to learn."""

    def elevation_map(self) -> ElevationMap:
        return self._elevation_map
