"""Choosing a cell on many local maps at once: the same rule as footsel.footholds.choose, which serves one."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import DISTANCE_WEIGHT, LegLayout
from footsel.terrain import CELLS
from footsel.terrain.local_map import cell_offsets


def nominal_distances(
    layout: LegLayout, leg: str, roll: NDArray[np.floating], pitch: NDArray[np.floating]
) -> NDArray[np.float64]:
    """(n, 40, 40) distance d_n of each cell to the nominal foothold of a base tilted by roll and pitch (n,), in [m].

    The nominal foothold turns with the yaw only, the hip point, where the map is centred, with the whole base.
    """
    roll, pitch = np.asarray(roll, dtype=np.float64), np.asarray(pitch, dtype=np.float64)
    x, y, z = layout.hips[leg]
    hip = np.stack(
        [
            np.cos(pitch) * x + np.sin(pitch) * (np.sin(roll) * y + np.cos(roll) * z),
            np.cos(roll) * y - np.sin(roll) * z,
        ],
        axis=-1,
    )
    nominal = layout.nominal_feet[leg][:2] - hip
    return np.asarray(np.linalg.norm(cell_offsets(CELLS, layout.resolution) - nominal[:, None, None], axis=-1))


def final_cost_maps(
    cost: NDArray[np.generic], allowed: NDArray[np.bool_], distances: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n, 40, 40) `Z_c + k d_n` where a cell may be chosen, inf elsewhere."""
    return np.where(allowed, cost.astype(np.float64) + DISTANCE_WEIGHT * distances, np.inf)


def pick_cells(final_cost: NDArray[np.float64], distances: NDArray[np.float64]) -> NDArray[np.intp]:
    """(n, 2) the cheapest cell (i, j) of each map, the nearer one of equals; -1 where there is none."""
    flat = final_cost.reshape(len(final_cost), -1)
    least = flat.min(axis=1, keepdims=True)
    cell = np.where(flat == least, distances.reshape(flat.shape), np.inf).argmin(axis=1)
    cells = np.stack(np.unravel_index(cell, final_cost.shape[1:]), axis=-1)
    cells[~np.isfinite(least[:, 0])] = -1
    return cells


def picks_below(
    final_cost: NDArray[np.float64],
    distances: NDArray[np.float64],
    infeasible: NDArray[np.float32],
    thresholds: Sequence[float],
) -> NDArray[np.intp]:
    """(len(thresholds), n, 2) what `pick_cells` picks of the cells whose p(infeasible) is below each threshold.

    With the cells in the order of their cost that is the first one below it, so one sorting serves all thresholds.
    """
    n, cells = len(final_cost), final_cost[0].size
    flat = final_cost.reshape(n, cells)
    order = np.lexsort((distances.reshape(n, cells), flat), axis=-1)
    doubt = np.where(np.isfinite(flat), infeasible.reshape(n, cells), np.float32(np.inf))
    least_so_far = np.minimum.accumulate(np.take_along_axis(doubt, order, axis=1), axis=1)
    picks = np.full((len(thresholds), n, 2), -1, dtype=np.intp)
    for index, threshold in enumerate(thresholds):
        first = np.count_nonzero(least_so_far >= np.float32(threshold), axis=1)
        found = np.flatnonzero(first < cells)
        cell = order[found, first[found]]
        picks[index, found] = np.stack(np.unravel_index(cell, final_cost.shape[1:]), axis=-1)
    return picks
