"""footsel in the socket for visual foothold adaptation of Quadruped-PyMPC: copy this file, and where its helper says
`from virall.vfa.vfa import VFA` say `from quadruped_pympc import VFA`.

The helper (quadruped_pympc/helpers/visual_foothold_adaptation.py there) calls one evaluator per leg:

    convex_data, _, safe_map, info = vfa(
        heightmap_data=..., base_linear_velocity=..., base_orientation=..., base_orientation_rate=...,
        gait_phase=..., return_info=True,
    )

heightmap_data is (rows, columns) of heights over the hip's z, aligned with the base's heading, rows toward -x and
columns toward -y (gym_quadruped/sensors/heightmap.py), so a map of 40x40 points 2 cm apart sees a whole workspace of
ANYmal. The foothold is convex_data[0][0], two corners of a rectangle of safe cells around it convex_data[1][0].x1 and
.y2, each a cell's number, which the helper asks for `.item()`.

Use it with a robot that there is a model for: a network knows one robot's legs.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel import ElevationMap
from footsel.errors import InputError
from footsel.footholds.choice import DISTANCE_WEIGHT
from footsel.footholds.pose import tilt_rotation
from footsel.runtime import FootholdSelector
from footsel.terrain.local_map import CELLS, cell_offsets

#: Their names of the legs.
LEG_OF = {"FL": "LF", "FR": "RF", "RL": "LH", "RR": "RH"}


class CellNumber(int):
    """Number of a cell, row by row.

    The helper finds the row as round(number / columns), which is the next one for every cell in the right half of its
    row. Division by a whole number therefore gives the row itself.
    """

    def item(self) -> "CellNumber":
        """As numpy's scalars have it."""
        return self

    def __truediv__(self, columns: Any) -> Any:
        return int(self) // columns


@dataclass(frozen=True)
class Rectangle:
    """Safe cells in rows and columns between two opposite corners."""

    x1: CellNumber
    y2: CellNumber


class VFA:
    """The evaluator of one leg.

    leg: FL, FR, RL or RR; LF, RF, LH or RH do too. model: of FootholdSelector.load.
    resolution: distance of the height map's points, in [m].
    centre: what the height map lies around, "nominal" for the leg's nominal foothold or "hip" for its hip point.

    Raises InputError for another leg or centre, ModelError for a model that cannot be read.
    """

    def __init__(
        self, leg: str, model: str | Path = "anymal_b", resolution: float = 0.02, centre: str = "nominal"
    ) -> None:
        self.leg = LEG_OF.get(leg, leg)
        if self.leg not in LEG_OF.values():
            raise InputError(f"unknown leg {leg!r}", f"choose from: {', '.join(LEG_OF)}")
        if centre not in ("nominal", "hip"):
            raise InputError(f"centre is {centre!r}", "choose from: nominal, hip")
        self._selector = FootholdSelector.load(model)
        self._resolution = resolution
        self._around_nominal = centre == "nominal"

    def __call__(
        self,
        heightmap_data: ArrayLike,
        base_linear_velocity: ArrayLike | None = None,
        base_orientation: ArrayLike = (0.0, 0.0, 0.0),
        base_orientation_rate: ArrayLike | None = None,
        gait_phase: float = 0.0,
        return_info: bool = True,
    ) -> tuple[tuple[list[CellNumber], list[Rectangle]], None, NDArray[np.bool_], dict[str, Any]]:
        """((foothold, rectangle), None, safe cells (rows, columns), info).

        heightmap_data: (rows, columns) heights over the hip's z, NaN = unknown, in [m]. base_orientation: roll, pitch,
        yaw, in [rad]. Velocity, rate and phase change nothing: the height map lies where the gait wants the foot.

        If no cell is safe both lists are empty, so that the caller's `convex_data[0][0]` raises IndexError instead of
        sending a foot somewhere; info["status"] is "none" and info["reason"] says why.
        """
        # Cell (0, 0) of ours is at the -x, -y corner.
        heights = np.asarray(heightmap_data, dtype=np.float32)[::-1, ::-1]
        roll, pitch = np.asarray(base_orientation, dtype=np.float64).reshape(-1)[:2]
        layout = self._selector.layout
        # N_i from the hip point in the heading frame; a tilted base moves its hips, not where feet should stand. [m]
        nominal = (layout.nominal_feet[self.leg] - tilt_rotation(roll, pitch) @ layout.hips[self.leg])[:2]
        terrain = ElevationMap(heights, self._resolution, nominal if self._around_nominal else np.zeros(2))
        local = terrain.sample(cell_offsets(CELLS, layout.resolution))
        cells = self._selector.evaluate(local, self.leg, roll, pitch)

        # Each point of theirs is judged as the cell of the local map that it lies in.
        x, y = np.meshgrid(terrain.x(), terrain.y(), indexing="ij")
        at = np.rint(np.stack([x, y]) / layout.resolution + (CELLS - 1) / 2).astype(int)
        inside = ((at >= 0) & (at < CELLS)).all(axis=0)
        i, j = np.clip(at, 0, CELLS - 1)
        safe = cells.feasible[i, j] & inside & terrain.known
        final = cells.cost[i, j] + DISTANCE_WEIGHT * np.hypot(x - nominal[0], y - nominal[1])
        safe, final = safe[::-1, ::-1], np.where(safe, final, np.inf)[::-1, ::-1]
        if not safe.any():
            info = {"status": "none", "reason": "the network calls no known cell feasible", "final_cost": None}
            return ([], []), None, safe, info if return_info else {}
        best = np.unravel_index(int(np.argmin(final)), final.shape)
        low, high = grown_rectangle(safe, (int(best[0]), int(best[1])))
        columns = safe.shape[1]
        rectangle = Rectangle(CellNumber(low[0] * columns + low[1]), CellNumber(high[0] * columns + high[1]))
        info = {"status": "ok", "reason": None, "final_cost": float(final[best])}
        foothold = CellNumber(int(best[0]) * columns + int(best[1]))
        return ([foothold], [rectangle]), None, safe, info if return_info else {}


def grown_rectangle(safe: NDArray[np.bool_], cell: tuple[int, int]) -> tuple[tuple[int, int], tuple[int, int]]:
    """First and last cell of a rectangle around `cell` that grows to every side as long as all of it is safe."""
    low, high = [*cell], [*cell]
    growing = True
    while growing:
        growing = False
        for axis in (0, 1):
            for bound, step, limit in ((low, -1, 0), (high, 1, safe.shape[axis] - 1)):
                if bound[axis] == limit:
                    continue
                bound[axis] += step
                if safe[low[0] : high[0] + 1, low[1] : high[1] + 1].all():
                    growing = True
                else:
                    bound[axis] -= step
    return (low[0], low[1]), (high[0], high[1])
