"""The fast oracle held against the brute-force reference, cell by cell."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import BasePose, Reason
from footsel.oracle import Label, Oracle
from footsel.oracle.brute_force import BruteForceOracle
from footsel.terrain import ElevationMap, LocalMap

#: Height of the base over the ground, as a share of the standing height.
HEIGHT_SHARE = (0.74, 1.23)


@dataclass
class Comparison:
    """What was compared and what differed.

    cells, reasons: number of cells, in all and by the reference's reason. differing: a line for each that differs.
    terrain_cost_error: the largest. margin_errors: of the cells whose margin was compared, in [m].
    """

    cells: int = 0
    differing: list[str] = field(default_factory=list)
    terrain_cost_error: float = 0.0
    margin_errors: list[float] = field(default_factory=list)
    reasons: NDArray[np.int64] = field(default_factory=lambda: np.zeros(len(Reason), dtype=np.int64))


def draw_local_map(
    oracle: Oracle, elevation_map: ElevationMap, leg: str, rng: np.random.Generator, tilt: float
) -> tuple[LocalMap, float, float]:
    """A local map of `leg` with the base 0.74 to 1.23 standing heights above the ground (ANYmal B: 0.36 to 0.60 m).

    tilt: roll and pitch lie within it, in [rad]. Returns the map, roll and pitch.
    """
    layout = oracle.robot.layout
    known = np.argwhere(elevation_map.known)
    while True:
        i, j = known[rng.integers(len(known))]
        x, y, yaw = elevation_map.x()[i], elevation_map.y()[j], rng.uniform(-np.pi, np.pi)
        ground = layout.ground_height(elevation_map, x, y, yaw)
        if not np.isnan(ground):
            break
    roll, pitch = rng.uniform(-tilt, tilt, 2)
    pose = BasePose(x, y, ground + rng.uniform(*HEIGHT_SHARE) * layout.standing_height, roll, pitch, yaw)
    return layout.local_map(elevation_map, pose, leg), roll, pitch


def compare(
    label: Label,
    reference: BruteForceOracle,
    local_map: LocalMap,
    tilt: tuple[float, float],
    cells: NDArray[np.intp],
    margins: int,
    into: Comparison,
) -> None:
    """Compare the label with the reference on `cells` (k, 2), and the margin on the first `margins` feasible ones."""
    for i, j in cells.tolist():
        feasible = bool(label.feasible[i, j])
        with_margin = feasible and margins > 0
        expected = reference.label_cell(local_map, *tilt, (i, j), with_margin=with_margin)
        into.cells += 1
        into.reasons[expected.reason] += 1
        found = Reason(int(label.reason[i, j]))
        if found != expected.reason:
            into.differing.append(f"cell {(i, j)}: {found.name}, the reference says {expected.reason.name}")
        elif found != Reason.UNKNOWN:
            error = abs(label.terrain_cost[i, j] - expected.terrain_cost)
            into.terrain_cost_error = max(into.terrain_cost_error, error)
            if with_margin:
                into.margin_errors.append(abs(label.kinematic_margin[i, j] - expected.margin))
                margins -= 1


def draw_cells(local_map: LocalMap, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Random cells (k, 2), known and unknown."""
    flat = rng.permutation(local_map.cells**2)[:count]
    return np.stack(np.unravel_index(flat, local_map.heights.shape), axis=-1)
