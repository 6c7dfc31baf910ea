"""One interface for everything that chooses footholds."""

import time
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping

from numpy.typing import ArrayLike

from footsel.footholds import BasePose, CellScores, Foothold, LegLayout, choose
from footsel.footholds.request import LegRequest, prepare
from footsel.legs import LEGS
from footsel.runtime import Timing
from footsel.terrain import ElevationMap


class Selector(ABC):
    """Chooses the cell of least final cost among those it calls feasible."""

    def __init__(self, layout: LegLayout) -> None:
        self.layout = layout

    @abstractmethod
    def score(self, request: LegRequest) -> CellScores:
        """Cost and feasibility of every cell of a leg's local map."""

    def select(
        self,
        elevation_map: ElevationMap,
        base_pose: "BasePose | ArrayLike",
        legs: Iterable[str] = LEGS,
        nominal: Mapping[str, ArrayLike] | None = None,
        top_k: int = 1,
    ) -> dict[str, Foothold]:
        """A foothold per leg; arguments and errors as FootholdSelector.select."""
        return self.select_timed(elevation_map, base_pose, legs, nominal, top_k)[0]

    def select_timed(
        self,
        elevation_map: ElevationMap,
        base_pose: "BasePose | ArrayLike",
        legs: Iterable[str] = LEGS,
        nominal: Mapping[str, ArrayLike] | None = None,
        top_k: int = 1,
    ) -> tuple[dict[str, Foothold], Timing]:
        """As `select`, and how long it took; only networks have a network time."""
        start = time.perf_counter()
        footholds = {
            request.leg: choose(self.score(request), request.local_map, request.nominal, top_k)
            for request in prepare(self.layout, elevation_map, base_pose, legs, nominal)
        }
        return footholds, Timing((time.perf_counter() - start) * 1e3, 0.0)
