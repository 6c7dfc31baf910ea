"""How far a depth reading is off, as a function of the depth."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.terrain.degradation import AXIAL


class DepthNoise(ABC):
    """Standard deviation of a depth reading, along the optical axis."""

    @abstractmethod
    def sigma(self, depth: NDArray[np.floating]) -> NDArray[np.floating]:
        """Of readings at these depths, same shape, all in [m]."""


@dataclass(frozen=True)
class StereoNoise(DepthNoise):
    """A stereo pair's: `z^2 s / (f B)`, what an error s of the disparity `d = f B / z` does to the depth.

    subpixel: s, standard deviation of the disparity, in [px]. focal_px: f of the imagers. baseline: B, in [m].
    """

    subpixel: float
    focal_px: float
    baseline: float

    def sigma(self, depth: NDArray[np.floating]) -> NDArray[np.floating]:
        """As above."""
        return np.asarray(depth * depth * (self.subpixel / (self.focal_px * self.baseline)))


@dataclass(frozen=True)
class FittedNoise(DepthNoise):
    """A fit to measurements: `offset + scale (z - centre)^2`. The defaults are a published fit of an Intel D435."""

    offset: float = AXIAL[0]
    scale: float = AXIAL[1]
    centre: float = AXIAL[2]

    def sigma(self, depth: NDArray[np.floating]) -> NDArray[np.floating]:
        """As above."""
        return np.asarray(self.offset + self.scale * (depth - self.centre) ** 2)
