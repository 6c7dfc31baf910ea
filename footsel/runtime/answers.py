"""From the candidates of one leg to its Foothold: ranked, verified, the previous one kept where it is as good."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import Foothold
from footsel.footholds.choice import CellCheck
from footsel.footholds.cost import COST_BINS, INFEASIBLE_COST
from footsel.footholds.foothold import Alternative
from footsel.runtime.judgement import Judgement
from footsel.runtime.leg_frames import LegFrames
from footsel.runtime.many import ManyFootholds
from footsel.runtime.picking import FinalCosts
from footsel.runtime.sampling import OFFSETS
from footsel.terrain import CELLS

WHY_NONE = "the network calls no known cell feasible"


class Candidate(NamedTuple):
    """A place for a foot.

    cell: flat index in the leg's map, mirrored for right legs. position: contact point in the world frame, in [m].
    final_cost: Z_c of the cell + k * distance. distance: to N_i, in [m].
    """

    cell: int
    position: tuple[float, float, float]
    final_cost: float
    distance: float


@dataclass(frozen=True, eq=False)
class Answers:
    """All that is known of m legs, to answer for each of them.

    nominal: (m, 3) N_i in the world frame, in [m]. resolution: side of a cell, in [m].
    distance_weight: k, in [cost / m]. max_distance: from N_i, in [m]; None if any will do.
    """

    judgement: Judgement
    frames: LegFrames
    final_costs: FinalCosts
    nominal: NDArray[np.float64]
    resolution: float
    distance_weight: float
    max_distance: float | None

    def foothold(
        self,
        leg: int,
        top_k: int,
        verify: CellCheck | None = None,
        previous: Candidate | None = None,
        hysteresis: float = 0.0,
    ) -> Foothold:
        """The cheapest candidate of one leg, or a foothold of status "none".

        verify: candidates go through it in their order until `top_k` of them are accepted.
        previous: comes before every candidate that is not cheaper by more than `hysteresis`, and stands for its cell.
        """
        nominal = tuple(self.nominal[leg].tolist())
        most = top_k if verify is None else CELLS * CELLS
        ranked = self._ranked(leg, most, previous, hysteresis)
        if verify is not None:
            ranked = (each for each in ranked if verify(self._cell(leg, each.cell), each.position))
        accepted = list(islice(ranked, top_k))
        if not accepted:
            reason = self._why_none(leg)
            return Foothold("none", reason, None, None, None, None, None, nominal, None, None)
        best = accepted[0]
        i, j = divmod(best.cell, CELLS)
        cost = self.judgement.cost.item(leg, i, j)
        return Foothold(
            status="ok",
            reason=None,
            position=best.position,
            cell=self._cell(leg, best.cell),
            cost=cost,
            # Any cell that is chosen is feasible, so its class is one of the thirteen bins.
            class_=min(int(cost * COST_BINS / INFEASIBLE_COST), COST_BINS - 1),
            final_cost=best.final_cost,
            nominal=nominal,
            distance_to_nominal=best.distance,
            confidence=float(np.float32(1) - self.judgement.infeasible[leg, i, j]),
            alternatives=tuple(Alternative(each.position, each.final_cost) for each in accepted[1:]),
        )

    def as_arrays(self, legs: Sequence[str]) -> ManyFootholds:
        """The cheapest candidates of all, the legs in this order; frames come leg after leg, all poses of each."""
        m = len(self.frames.legs)
        rows, best = np.arange(m), self.final_costs.best
        total = self.final_costs.total[rows, best]
        found = np.isfinite(total)
        i, j = np.divmod(best, CELLS)
        cells = np.stack([i, np.where(self.frames.side > 0, j, CELLS - 1 - j)], axis=-1)
        xy = self.frames.to_world(rows, OFFSETS[i] * self.resolution, OFFSETS[j] * self.resolution)
        z = self.frames.hips[:, 2] + self.judgement.heights[rows, i, j]
        planes = {
            "found": found,
            "positions": np.where(found[:, None], np.stack([*xy, z], axis=-1), np.nan),
            "cells": np.where(found[:, None], cells, -1),
            "costs": np.where(found, self.judgement.cost[rows, i, j], np.inf),
            "final_costs": total,
            "nominal": self.nominal,
            "distances": np.where(found, self.final_costs.distances[rows, best], np.nan),
            "confidences": np.where(found, np.float32(1) - self.judgement.infeasible[rows, i, j], 0.0),
        }
        # (l * n, ...) -> (n, l, ...), the legs as they were asked for.
        poses = self.frames.legs.count(self.frames.legs[0])
        order = [self.frames.legs.index(leg) // poses for leg in legs]
        return ManyFootholds(
            tuple(legs),
            **{
                name: plane.reshape(-1, poses, *plane.shape[1:])[order].swapaxes(0, 1) for name, plane in planes.items()
            },
        )

    def previous(self, leg: int, x: float, y: float, z: float) -> Candidate | None:
        """The foothold that stood at world (x, y), if it may still be chosen; in its place, not in its cell's middle.

        z: today's height there, NaN = unknown, in [m].
        """
        in_map = self.frames.in_map(np.array((x, y)))
        i, j = (round(along.item(leg) / self.resolution - float(OFFSETS[0])) for along in in_map)
        distance = float(np.hypot(x - self.nominal[leg, 0], y - self.nominal[leg, 1]))
        too_far = self.max_distance is not None and distance > self.max_distance
        if np.isnan(z) or too_far or not (0 <= i < CELLS and 0 <= j < CELLS):
            return None
        cell = i * CELLS + j
        if not np.isfinite(self.final_costs.total[leg, cell]):
            return None
        final_cost = float(self.judgement.cost[leg, i, j]) + self.distance_weight * distance
        return Candidate(cell, (x, y, z), final_cost, distance)

    def _ranked(self, leg: int, most: int, previous: Candidate | None, hysteresis: float) -> Iterator[Candidate]:
        waiting = previous
        # The cell of the previous foothold, which stands for it, may be among the cheapest.
        for cell in self.final_costs.ranked(leg, most + (previous is not None)):
            total = self.final_costs.total.item(leg, cell)
            if waiting is not None and not total < waiting.final_cost - hysteresis:
                yield waiting
                waiting = None
            if previous is None or cell != previous.cell:
                yield Candidate(cell, self._position(leg, cell), total, self.final_costs.distances.item(leg, cell))
        if waiting is not None:
            yield waiting

    def _cell(self, leg: int, flat: int) -> tuple[int, int]:
        """(i, j) in the leg's own local map."""
        i, j = divmod(flat, CELLS)
        return i, j if self.frames.side[leg] > 0 else CELLS - 1 - j

    def _position(self, leg: int, flat: int) -> tuple[float, float, float]:
        """Contact point of a cell in the world frame, in [m]."""
        i, j = divmod(flat, CELLS)
        x, y = self.frames.to_world(leg, OFFSETS.item(i) * self.resolution, OFFSETS.item(j) * self.resolution)
        return float(x), float(y), self.frames.hips.item(leg, 2) + self.judgement.heights.item(leg, i, j)

    def _why_none(self, leg: int) -> str:
        candidates = int(np.isfinite(self.final_costs.total[leg]).sum())
        if candidates:
            return f"none of {candidates} candidates passed the verification"
        known = ~np.isnan(self.judgement.heights[leg])
        if not known.any():
            return "no cell of the local map is known"
        if (known & (self.judgement.infeasible[leg] < self.judgement.feasible_below[leg])).any():
            return f"no feasible cell lies within {self.max_distance:g} m of the nominal foothold"
        return WHY_NONE
