"""From an elevation map and a base pose to footholds, with the network alone: what runs on the robot."""

import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.footholds import BasePose, Foothold, LegLayout
from footsel.footholds.choice import CellCheck
from footsel.footholds.cost import COST_BINS
from footsel.legs import LEGS, check_leg, check_legs, is_right, pair_of
from footsel.runtime import inputs
from footsel.runtime.answers import Answers
from footsel.runtime.contract import LOGITS_OUTPUT
from footsel.runtime.evaluation import CellEvaluation, assemble
from footsel.runtime.judgement import judge
from footsel.runtime.leg_frames import Body, LegFrames
from footsel.runtime.many import ManyFootholds
from footsel.runtime.model_folder import DEFAULT_VARIANT, find_model_folder, load_networks
from footsel.runtime.network import COSTS, Network
from footsel.runtime.picking import weigh
from footsel.runtime.plausibility import UnitWarning
from footsel.runtime.sampling import sample_legs
from footsel.terrain import CELLS, ElevationMap

#: verify(leg, base_pose, cell, position) -> whether the candidate may be used. base_pose: (x, y, z, roll, pitch, yaw)
#: in the world frame; cell: (i, j) in the leg's local map; position: contact point in the world frame.
Verify = Callable[[str, tuple[float, ...], tuple[int, int], tuple[float, float, float]], bool]

#: Poses whose surroundings are sampled and weighed together in `select_many`: arrays that stay in a core's cache.
_POSES = 4
#: By how much a new foothold must be better than the previous one to be preferred to it, half a class. [cost]
HYSTERESIS = 10.0


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
        self._body = Body(self._contract.layout)
        self._units = UnitWarning(self._contract.layout)

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
        *,
        previous: "Mapping[str, Foothold | ArrayLike | None] | None" = None,
        hysteresis: float = HYSTERESIS,
        max_distance: float | None = None,
    ) -> dict[str, Foothold]:
        """The cheapest feasible foothold of each leg, or one of status "none" that says why.

        base_pose: x, y, z, roll, pitch, yaw of the base in the world frame, in [m] and [rad].
        nominal: N_i of any leg as world (x, y) or (x, y, z), in [m]; the robot's nominal stance for legs not named.
        top_k: how many candidates to name in all, the chosen one and its alternatives.
        verify: called on candidates in their order until `top_k` of them are accepted.
        previous: footholds of any leg to stay with, as an earlier call answered or as world (x, y). One that may still
            be chosen is kept in its place unless another's final cost is lower by more than `hysteresis`.
        max_distance: from N_i, in [m]; cells farther away are not chosen.

        Raises InputError for a base off the map and for values that make no sense, UnknownNameError for a leg.
        """
        return self.select_timed(
            elevation_map,
            base_pose,
            legs,
            nominal,
            top_k,
            verify,
            previous=previous,
            hysteresis=hysteresis,
            max_distance=max_distance,
        )[0]

    def select_timed(
        self,
        elevation_map: ElevationMap,
        base_pose: "BasePose | ArrayLike",
        legs: Iterable[str] = LEGS,
        nominal: Mapping[str, ArrayLike] | None = None,
        top_k: int = 1,
        verify: Verify | None = None,
        *,
        previous: "Mapping[str, Foothold | ArrayLike | None] | None" = None,
        hysteresis: float = HYSTERESIS,
        max_distance: float | None = None,
    ) -> tuple[dict[str, Foothold], Timing]:
        """As `select`, and how long it took."""
        start = time.perf_counter()
        top_k = inputs.checked_count("top_k", top_k)
        hysteresis = inputs.checked_limit("hysteresis", hysteresis, "give a final cost of 0 or more")
        max_distance = _checked_max_distance(max_distance)
        numbers = inputs.checked_pose(self.layout, inputs.checked_map(elevation_map), base_pose)
        points, before = inputs.checked_points("nominal foothold", nominal), inputs.checked_previous(previous)
        legs = check_legs(legs)
        if not legs:
            return {}, Timing((time.perf_counter() - start) * 1e3, 0.0)

        frames = self._body.place(np.array([numbers]), sorted(legs, key=pair_of), points)
        answers, network_ms = self._answers(elevation_map, frames, max_distance)
        index = {leg: number for number, leg in enumerate(frames.legs)}
        kept = {}
        if stood := [leg for leg in legs if leg in before]:
            places = np.array([before[leg][:2] for leg in stood])
            for leg, (x, y), z in zip(stood, places.tolist(), elevation_map.sample(places).tolist(), strict=True):
                kept[leg] = answers.previous(index[leg], x, y, z)
        footholds = {}
        for leg in legs:
            check = None if verify is None else _bind(verify, leg, tuple(numbers))
            footholds[leg] = answers.foothold(index[leg], top_k, check, kept.get(leg), hysteresis)
        return footholds, Timing((time.perf_counter() - start) * 1e3, network_ms)

    def select_many(
        self,
        elevation_map: ElevationMap,
        base_poses: ArrayLike,
        legs: Iterable[str] = LEGS,
        nominal: Mapping[str, ArrayLike] | None = None,
        *,
        max_distance: float | None = None,
        threads: int = 1,
    ) -> ManyFootholds:
        """The cheapest feasible foothold of each leg at each of many base poses, as arrays.

        base_poses: (n, 6) x, y, z, roll, pitch, yaw of the base in the world frame, in [m] and [rad].
        nominal: N_i of any leg, (2,) or (3,) for all poses or (n, 2) or (n, 3), in the world frame, in [m]; the robot's
            nominal stance for legs not named.
        max_distance: as in `select`.
        threads: that share the poses; more than there are cores gain nothing.

        Raises InputError for a base off the map and for values that make no sense, UnknownNameError for a leg.
        """
        max_distance, threads = _checked_max_distance(max_distance), inputs.checked_count("threads", threads)
        poses = inputs.checked_poses(base_poses)
        inputs.checked_map(elevation_map)
        for pose in poses[~elevation_map.contains(poses[:, :2])][:1]:
            self.layout.check_on_map(elevation_map, BasePose.of(pose))
        points = inputs.checked_points("nominal foothold", nominal, len(poses))
        legs = check_legs(legs)
        if not (len(poses) and legs):
            return ManyFootholds.none(len(poses), legs)

        def answer(start: int) -> ManyFootholds:
            part = slice(start, start + _POSES)
            nearby = {leg: point[part] if point.ndim == 2 else point for leg, point in points.items()}
            frames = self._body.place(poses[part], sorted(legs, key=pair_of), nearby)
            return self._answers(elevation_map, frames, max_distance)[0].as_arrays(legs)

        starts = range(0, len(poses), _POSES)
        if threads == 1:
            return ManyFootholds.concatenate([answer(start) for start in starts])
        with ThreadPoolExecutor(threads) as pool:
            return ManyFootholds.concatenate(list(pool.map(answer, starts)))

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
        heights = inputs.checked_heights(local_heights)
        single = heights.ndim == 2
        heights = _mirrored(heights.reshape(-1, CELLS, CELLS), leg)
        rolls, pitches = (
            inputs.checked_tilt(name, tilt, len(heights)) for name, tilt in (("roll", roll), ("pitch", pitch))
        )
        rolls = -rolls if is_right(leg) else rolls
        logits, infeasible, cost = network.answers(heights, rolls, pitches, LOGITS_OUTPUT, *COSTS)
        likeliest = logits[:, :COST_BINS].argmax(axis=1)
        result = assemble(likeliest, infeasible, cost, ~np.isnan(heights), network.contract.feasible_below)
        planes = (_mirrored(plane, leg) for plane in (result.class_, result.cost, result.feasible, result.confidence))
        return CellEvaluation(*(plane[0] if single else plane for plane in planes))

    def _answers(
        self, elevation_map: ElevationMap, frames: LegFrames, max_distance: float | None
    ) -> tuple[Answers, float]:
        """What is thought of the surroundings of all legs, a pair's beside each other; and the network's ms."""
        layout, weight = self.layout, self._contract.distance_weight
        nominal_xy = frames.nominal[:, :2]
        heights, terrain = sample_legs(
            elevation_map, frames.hips, frames.heading, frames.side, nominal_xy, layout.resolution
        )
        self._units.check(heights)
        start = time.perf_counter()
        judgement = judge(self._networks, heights, frames)
        network_ms = (time.perf_counter() - start) * 1e3
        final_costs = weigh(judgement, frames, layout.resolution, weight, max_distance)
        nominal = frames.nominal_on(terrain)
        return Answers(judgement, frames, final_costs, nominal, layout.resolution, weight, max_distance), network_ms


def _mirrored(plane: NDArray[Any], leg: str) -> NDArray[Any]:
    """A right leg's plane as its left twin would see it, and back: the last axis, y, turned round."""
    return plane[..., ::-1] if is_right(leg) else plane


def _bind(verify: Verify, leg: str, base_pose: tuple[float, ...]) -> CellCheck:
    return lambda cell, position: bool(verify(leg, base_pose, cell, position))


def _checked_max_distance(distance: float | None) -> float | None:
    return None if distance is None else inputs.checked_limit("max_distance", distance, "give metres, or None")
