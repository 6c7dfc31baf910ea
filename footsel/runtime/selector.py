"""From an elevation map and a base pose to footholds, with the network alone: what runs on the robot."""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import InputError
from footsel.footholds import BasePose, CellScores, Foothold, LegLayout, choose
from footsel.footholds.choice import CellCheck
from footsel.footholds.request import LegRequest, prepare
from footsel.legs import LEGS, check_leg, is_right, pair_of
from footsel.runtime.evaluation import CellEvaluation, decode, decode_costs
from footsel.runtime.inputs import checked_heights, checked_tilt
from footsel.runtime.model_folder import DEFAULT_VARIANT, find_model_folder, load_networks
from footsel.runtime.network import Network
from footsel.terrain import CELLS, ElevationMap

#: verify(leg, base_pose, cell, position) -> whether the candidate may be used. base_pose: (x, y, z, roll, pitch, yaw)
#: in the world frame; cell: (i, j) in the leg's local map; position: contact point in the world frame.
Verify = Callable[[str, tuple[float, ...], tuple[int, int], tuple[float, float, float]], bool]

WHY_NONE = "the network calls no known cell feasible"


@dataclass(frozen=True)
class Timing:
    """Wall time of one selection, in [ms]. network: encoding, inference and decoding, a part of total."""

    total: float
    network: float


class FootholdSelector:
    """Footholds by the network; numpy and onnxruntime are all it needs. Safe to call from several threads at once."""

    def __init__(self, networks: Mapping[str, Network]) -> None:
        """From the "front" and the "hind" network of one robot; `load` reads them from a released model."""
        self._networks = dict(networks)
        self._contract = self._networks["front"].contract

    @classmethod
    def load(cls, model: str | Path = "anymal_b", variant: str = DEFAULT_VARIANT) -> "FootholdSelector":
        """A released model by name, or the path of a model folder.

        variant: "float32", or "int8" where the folder has it.

        Raises ModelError if there is no such model, or if its files are missing, damaged or do not belong together.
        """
        return cls(load_networks(find_model_folder(model), variant))

    @property
    def robot(self) -> str:
        """Name of the robot that the networks were trained for."""
        return self._contract.robot

    @property
    def layout(self) -> LegLayout:
        """Hip points, nominal feet and scale of the local maps."""
        return self._contract.layout

    def select(
        self,
        elevation_map: ElevationMap,
        base_pose: "BasePose | ArrayLike",
        legs: Iterable[str] = LEGS,
        nominal: Mapping[str, ArrayLike] | None = None,
        top_k: int = 1,
        verify: Verify | None = None,
    ) -> dict[str, Foothold]:
        """The cheapest feasible foothold of each leg, or one of status "none" that says why.

        base_pose: x, y, z, roll, pitch, yaw of the base in the world frame, in [m] and [rad].
        nominal: N_i of any leg as world (x, y) or (x, y, z), in [m]; the robot's nominal stance for legs not named.
        top_k: how many candidates to name in all, the chosen one and its alternatives.
        verify: called on candidates in the order of their final cost until `top_k` of them are accepted.

        Raises InputError for a base off the map and for values that make no sense, UnknownNameError for a leg.
        """
        return self.select_timed(elevation_map, base_pose, legs, nominal, top_k, verify)[0]

    def select_timed(
        self,
        elevation_map: ElevationMap,
        base_pose: "BasePose | ArrayLike",
        legs: Iterable[str] = LEGS,
        nominal: Mapping[str, ArrayLike] | None = None,
        top_k: int = 1,
        verify: Verify | None = None,
    ) -> tuple[dict[str, Foothold], Timing]:
        """As `select`, and how long it took."""
        start = time.perf_counter()
        if not isinstance(top_k, (int, np.integer)) or top_k < 1:
            raise InputError(f"top_k is {top_k!r}", "give a whole number of 1 or more")
        requests = prepare(self.layout, elevation_map, base_pose, legs, nominal)

        network_start = time.perf_counter()
        scores = self._scores(requests)
        network_ms = (time.perf_counter() - network_start) * 1e3

        weight = self._contract.distance_weight
        footholds = {
            request.leg: choose(
                scores[request.leg],
                request.local_map,
                request.nominal,
                int(top_k),
                None if verify is None else _bind(verify, request),
                weight,
            )
            for request in requests
        }
        return footholds, Timing((time.perf_counter() - start) * 1e3, network_ms)

    def evaluate(
        self, local_heights: ArrayLike, leg: str, roll: ArrayLike = 0.0, pitch: ArrayLike = 0.0
    ) -> CellEvaluation:
        """Class, cost, feasibility and confidence per cell, for those with their own mapping.

        local_heights: (40, 40) or (n, 40, 40) terrain height relative to the leg's hip point L_i, i along the base's
            heading and j to its left, cells of `layout.resolution`, NaN = unknown, in [m].
        roll, pitch: tilt of the base, one for all maps or (n,), in [rad].

        Raises InputError for another shape and for infinite values, UnknownNameError for a leg.
        """
        network = self._networks[pair_of(check_leg(leg))]
        heights = checked_heights(local_heights)
        single = heights.ndim == 2
        heights = heights.reshape(-1, CELLS, CELLS)
        rolls, pitches = (checked_tilt(name, tilt, len(heights)) for name, tilt in (("roll", roll), ("pitch", pitch)))
        heights = _mirrored(heights, leg)
        probabilities = network.probabilities(heights, _mirrored_roll(rolls, leg), pitches)
        result = decode(probabilities, ~np.isnan(heights), network.contract.feasible_below)
        planes = (_mirrored(plane, leg) for plane in (result.class_, result.cost, result.feasible, result.confidence))
        return CellEvaluation(*(plane[0] if single else plane for plane in planes))

    def _scores(self, requests: Sequence[LegRequest]) -> dict[str, CellScores]:
        """What is thought of every leg's cells; a pair's two legs run as one batch, the right one mirrored."""
        scores = {}
        for pair, network in self._networks.items():
            batch = [request for request in requests if pair_of(request.leg) == pair]
            if not batch:
                continue
            heights = np.stack([_mirrored(request.local_map.heights, request.leg) for request in batch])
            roll = np.stack([_mirrored_roll(np.array(request.pose.roll), request.leg) for request in batch])
            probabilities = network.probabilities(heights, roll, batch[0].pose.pitch)
            decoded = decode_costs(probabilities, ~np.isnan(heights), network.contract.feasible_below)
            for request, *planes in zip(batch, *decoded, strict=True):
                cost, feasible, confidence = (_mirrored(plane, request.leg) for plane in planes)
                scores[request.leg] = CellScores(cost, feasible, WHY_NONE, confidence)
        return scores


def _mirrored(plane: NDArray[Any], leg: str) -> NDArray[Any]:
    """A right leg's plane as its left twin would see it, and back: the last axis, y, turned round."""
    return plane[..., ::-1] if is_right(leg) else plane


def _mirrored_roll(roll: NDArray[np.float64], leg: str) -> NDArray[np.float64]:
    """The roll that goes with `_mirrored`."""
    return -roll if is_right(leg) else roll


def _bind(verify: Verify, request: LegRequest) -> CellCheck:
    numbers = tuple(request.pose.as_list())
    return lambda cell, position: bool(verify(request.leg, numbers, cell, position))
