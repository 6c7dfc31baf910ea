"""What an elevation map is like and how it is updated."""

from dataclasses import dataclass

import numpy as np

from footsel.errors import InputError


@dataclass(frozen=True)
class MappingConfig:
    """Settings of an ElevationMapping; the defaults give 6x6 m.

    cells: along each side. resolution: side of a cell, in [m].
    gate: readings that differ by more than so many standard deviations are of different surfaces.
    spread: the readings that one image has of a cell are of several heights if they spread by more than this, relative
    to their noise. It is lower than the gate: many readings tell more than one.
    slope: rise per metre that terrain is reckoned to have; it turns errors of place into errors of height.
    multi_height_variance: what a cell's variance grows by when a reading contradicts it, in [m^2].
    variance: bounds of a cell's height variance, in [m^2]. horizontal_variance: of its place's, likewise.
    sight: a cell is removed if an image looks through it so many standard deviations below its top.
    doubt: a cell is hidden once this many more images looked past its top than at it. votes: no more are counted,
    either way, so that it may show again.
    body_margin: how much thicker the robot's own bodies are taken to be, in [m].
    """

    cells: int = 300
    resolution: float = 0.02
    gate: float = 2.5
    spread: float = 1.5
    slope: float = 0.2
    multi_height_variance: float = 1e-4
    variance: tuple[float, float] = (9e-6, 0.01)
    horizontal_variance: tuple[float, float] = (1e-4, 0.25)
    sight: float = 3.0
    doubt: float = 5.0
    votes: float = 8.0
    body_margin: float = 0.05

    def __post_init__(self) -> None:
        if self.cells < 2 or not (np.isfinite(self.resolution) and self.resolution > 0):
            raise InputError(
                f"a map of {self.cells} cells of {self.resolution} m a side", "expected two or more, above 0 m"
            )
        for name in ("gate", "spread", "slope", "multi_height_variance", "sight", "doubt", "votes", "body_margin"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"{name} is {value}", "expected a number from 0")
        for name in ("variance", "horizontal_variance"):
            low, high = getattr(self, name)
            if not 0 < low <= high < np.inf:
                raise InputError(f"bounds of the {name} are {low}, {high}", "expected 0 < low <= high, in m^2")
