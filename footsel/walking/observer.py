"""Who watches a walk: pictures, videos and reports are made by observers, which change nothing."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import BasePose, Foothold
from footsel.terrain import ElevationMap
from footsel.walking.result import WalkResult
from footsel.walking.simulation.simulation import Simulation

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Choice:
    """One answer of the selector in the loop.

    time: in [s]. leg: that is to swing. pose: of the base at touchdown, as the selector was told.
    elevation_map: as known then. nominal: N_i that the gait gave, world xy in [m]. foothold: the answer.
    """

    time: float
    leg: str
    pose: BasePose
    elevation_map: ElevationMap
    nominal: tuple[float, float]
    foothold: Foothold


@dataclass(frozen=True, eq=False)
class Moment:
    """The walk at one time.

    time: in [s]. base: (4, 4) true placement of the base in W. joints: (12,) by LEGS and HAA HFE KFE, in [rad].
    swing_leg: the leg in the air, if any.
    footholds: leg -> (3,) contact point where it stands, or where it is going to if it swings, in W, in [m].
    support_polygon: (k, 3) contact points of the standing feet, in order around the polygon, in [m].
    choice: the last one. simulation: to render from; observers do not step it.
    """

    time: float
    base: Array
    joints: Array
    swing_leg: str | None
    footholds: Mapping[str, Array]
    support_polygon: Array
    choice: Choice | None
    simulation: Simulation


class WalkObserver(ABC):
    """Watches a walk."""

    @abstractmethod
    def see(self, moment: Moment) -> None:
        """Called every OBSERVER_PERIOD of simulated time (footsel.walking.walk)."""

    def see_choice(self, moment: Moment) -> None:  # noqa: B027 - most observers need no more than `see`
        """Called on every answer of the selector, "none" too; it is `moment.choice`."""

    def see_end(self, moment: Moment, result: WalkResult) -> None:  # noqa: B027
        """Called once, when the walk is over."""
