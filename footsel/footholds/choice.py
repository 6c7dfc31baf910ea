"""From a cost per cell to a foothold: the cheapest feasible cell by `c_final = Z_c + k d_n` (the paper, equation 3)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.cost import cost_to_class
from footsel.footholds.foothold import Alternative, Foothold
from footsel.terrain import LocalMap

#: Weight k of the distance to the nominal foothold, section III-C of the paper. [cost / m]
DISTANCE_WEIGHT = 160.0

#: verify(cell, position) -> whether the candidate may be used.
CellCheck = Callable[[tuple[int, int], tuple[float, float, float]], bool]


@dataclass(frozen=True, eq=False)
class CellScores:
    """What a selector thinks of every cell of a local map.

    cost: (n, n) Z_c in [0, 255]; only meaningful where feasible.
    feasible: (n, n) which cells may be chosen; unknown cells are never chosen, whatever stands here.
    why_none: the answer's reason if no known cell is feasible.
    confidence: (n, n) probability that the cell is feasible, of those selectors that estimate one.
    """

    cost: NDArray[np.floating]
    feasible: NDArray[np.bool_]
    why_none: str = "no known cell is feasible"
    confidence: NDArray[np.floating] | None = None


def final_costs(
    scores: CellScores, local_map: LocalMap, nominal_xy: NDArray[np.float64], distance_weight: float = DISTANCE_WEIGHT
) -> NDArray[np.float64]:
    """(n, n) `Z_c + k d_n` of the cells that may be chosen, inf elsewhere."""
    allowed = scores.feasible & local_map.known
    return np.where(allowed, scores.cost + distance_weight * local_map.distances_to(nominal_xy), np.inf)


def ranked_cells(final_cost: NDArray[np.float64], distances: NDArray[np.float64], most: int) -> NDArray[np.intp]:
    """(m, 2) cells of finite final cost, cheapest first, at most `most`; equal costs go to the cell nearer to N_i."""
    flat = final_cost.ravel()
    finite = int(np.isfinite(flat).sum())
    if finite == 0 or most <= 0:
        return np.empty((0, 2), dtype=np.intp)
    if most < finite:
        # Only what can be among the first `most`, ties included, is sorted.
        limit = np.partition(flat, most - 1)[most - 1]
        candidates = np.flatnonzero(flat <= limit)
    else:
        candidates = np.flatnonzero(np.isfinite(flat))
    order = np.lexsort((distances.ravel()[candidates], flat[candidates]))
    return np.stack(np.unravel_index(candidates[order][:most], final_cost.shape), axis=-1)


def choose(
    scores: CellScores,
    local_map: LocalMap,
    nominal: tuple[float, float, float],
    top_k: int = 1,
    verify: CellCheck | None = None,
    distance_weight: float = DISTANCE_WEIGHT,
) -> Foothold:
    """The cheapest feasible known cell, or a foothold of status "none".

    nominal: N_i in the world frame, in [m].
    top_k: how many candidates to name in all, the chosen one and its alternatives.
    verify: candidates go through it in the order of their cost until one is accepted.
    """
    nominal_xy = np.array(nominal[:2])
    distances = local_map.distances_to(nominal_xy)
    total = final_costs(scores, local_map, nominal_xy, distance_weight)
    ranked = ranked_cells(total, distances, total.size if verify else top_k)
    positions = local_map.positions()

    def position(cell: NDArray[np.intp]) -> tuple[float, float, float]:
        x, y, z = positions[cell[0], cell[1]].tolist()
        return x, y, z

    accepted = []
    for cell in ranked:
        if verify is None or verify((int(cell[0]), int(cell[1])), position(cell)):
            accepted.append(cell)
        if len(accepted) == top_k:
            break
    if not accepted:
        reason = scores.why_none
        if not local_map.known.any():
            reason = "no cell of the local map is known"
        elif len(ranked):
            reason = f"none of {len(ranked)} candidates passed the verification"
        return Foothold("none", reason, None, None, None, None, None, nominal, None, None)
    i, j = (int(index) for index in accepted[0])
    cost = float(scores.cost[i, j])
    return Foothold(
        status="ok",
        reason=None,
        position=position(accepted[0]),
        cell=(i, j),
        cost=cost,
        # Any cell that is chosen is feasible, so its class is one of the thirteen bins.
        class_=int(cost_to_class(min(cost, 254.0))),
        final_cost=float(total[i, j]),
        nominal=nominal,
        distance_to_nominal=float(distances[i, j]),
        confidence=None if scores.confidence is None else float(scores.confidence[i, j]),
        alternatives=tuple(Alternative(position(cell), float(total[cell[0], cell[1]])) for cell in accepted[1:]),
    )
