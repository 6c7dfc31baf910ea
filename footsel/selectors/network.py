"""The network as a selector, alone and with the oracle to verify its picks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.footholds import BasePose, CellScores, Foothold
from footsel.footholds.request import LegRequest
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector, Timing
from footsel.selectors.base import Selector
from footsel.terrain import ElevationMap

if TYPE_CHECKING:
    from footsel.oracle import Oracle


class NetworkSelector(Selector):
    """`cnn`: the embedded runtime, which never asks the oracle."""

    def __init__(self, runtime: FootholdSelector) -> None:
        super().__init__(runtime.layout)
        self.runtime = runtime

    def score(self, request: LegRequest) -> CellScores:
        cells = self.runtime.evaluate(request.local_map.heights, request.leg, request.pose.roll, request.pose.pitch)
        return CellScores(cells.cost, cells.feasible, confidence=cells.confidence)

    def select_timed(
        self,
        elevation_map: ElevationMap,
        base_pose: BasePose | ArrayLike,
        legs: Iterable[str] = LEGS,
        nominal: Mapping[str, ArrayLike] | None = None,
        top_k: int = 1,
    ) -> tuple[dict[str, Foothold], Timing]:
        """The runtime's own way, all legs of a pair in one batch."""
        return self.runtime.select_timed(elevation_map, base_pose, legs, nominal, top_k)


class VerifiedNetworkSelector(NetworkSelector):
    """`cnn+verify`: candidates in the network's order, until the oracle accepts one."""

    def __init__(self, runtime: FootholdSelector, oracle: Oracle) -> None:
        super().__init__(runtime)
        self._oracle = oracle

    def select_timed(
        self,
        elevation_map: ElevationMap,
        base_pose: BasePose | ArrayLike,
        legs: Iterable[str] = LEGS,
        nominal: Mapping[str, ArrayLike] | None = None,
        top_k: int = 1,
    ) -> tuple[dict[str, Foothold], Timing]:
        """As the network's, on a map that the oracle labels only for legs with a candidate."""
        pose = BasePose.of(base_pose)
        feasible: dict[str, NDArray[np.bool_]] = {}

        def verify(leg: str, _: tuple[float, ...], cell: tuple[int, int], __: tuple[float, float, float]) -> bool:
            if leg not in feasible:
                local_map = self.layout.local_map(elevation_map, pose, leg)
                feasible[leg] = self._oracle.label(local_map, leg, pose.roll, pose.pitch).feasible
            return bool(feasible[leg][cell])

        return self.runtime.select_timed(elevation_map, pose, legs, nominal, top_k, verify)
