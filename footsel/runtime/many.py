"""Footholds of many base poses at once, as arrays: for planners that score hundreds of postures a step."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class ManyFootholds:
    """The foothold of each of l legs at each of n base poses. Where there is none, `found` is False.

    legs: (l,) names, the second axis of all arrays.
    found: (n, l) whether there is a foothold.
    positions: (n, l, 3) contact points in the world frame, NaN where there is none, in [m].
    cells: (n, l, 2) (i, j) in the leg's local map, -1 where there is none.
    costs: (n, l) Z_c. final_costs: (n, l) Z_c + k d_n. Both inf where there is none.
    nominal: (n, l, 3) N_i in the world frame, in [m]. distances: (n, l) d_n, NaN where there is no foothold, in [m].
    confidences: (n, l) 1 - p(infeasible), 0 where there is none.
    """

    legs: tuple[str, ...]
    found: NDArray[np.bool_]
    positions: NDArray[np.float64]
    cells: NDArray[np.intp]
    costs: NDArray[np.float64]
    final_costs: NDArray[np.float64]
    nominal: NDArray[np.float64]
    distances: NDArray[np.float64]
    confidences: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.found)

    @property
    def pose_costs(self) -> NDArray[np.float64]:
        """(n,) sum of the final costs over the legs, inf for a pose that leaves a leg without a foothold."""
        return np.asarray(self.final_costs.sum(axis=1))

    def best_pose(self) -> int | None:
        """Index of the pose whose footholds cost least in all; None if every pose leaves a leg without one."""
        costs = self.pose_costs
        return int(costs.argmin()) if np.isfinite(costs).any() else None

    @classmethod
    def none(cls, poses: int, legs: "Sequence[str]") -> "ManyFootholds":
        """Of no poses, or of no legs."""
        plane = np.empty((poses, len(legs)))
        triple, pair = np.empty((*plane.shape, 3)), np.empty((*plane.shape, 2), dtype=np.intp)
        return cls(tuple(legs), plane.astype(bool), triple, pair, plane, plane, triple, plane, plane)

    @classmethod
    def concatenate(cls, parts: "Sequence[ManyFootholds]") -> "ManyFootholds":
        """The poses of all parts, in order; the legs are the same."""
        arrays = [f.name for f in fields(cls) if f.name != "legs"]
        return cls(parts[0].legs, **{name: np.concatenate([getattr(each, name) for each in parts]) for name in arrays})
