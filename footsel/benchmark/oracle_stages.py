"""The oracle's constraints one by one: time per cell of the fast way and of the brute-force way."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.benchmark.cases import Case
from footsel.benchmark.timing import milliseconds, with_progress
from footsel.footholds.pose import tilt_rotation
from footsel.footholds.reasons import Reason
from footsel.oracle import Oracle
from footsel.oracle.brute_force import BruteForceOracle
from footsel.oracle.brute_force_terrain import terrain_cost
from footsel.oracle.overlap import UNDECIDED
from footsel.oracle.self_collision import ExactSelfCollision
from footsel.oracle.swing_bodies import SwingBodies
from footsel.oracle.tables import load_tables
from footsel.oracle.terrain_collision import Terrain, TerrainCollision
from footsel.oracle.terrain_cost import terrain_costs
from footsel.robot.robot import Robot
from footsel.terrain import LocalMap
from footsel.terrain.local_map import cell_offsets

#: A left leg, whose tables are its own.
LEG = "LF"

Array = NDArray[np.float64]
#: Stage -> (what does it for all given cells, number of these cells).
Stages = Mapping[str, tuple[Callable[[], object], int]]


@dataclass(frozen=True, eq=False)
class Work:
    """Cells of one local map on their way through the stages.

    tilt: (3, 3) base to heading frame. cells: (k, 2) known cells and feet: (k, 3) their foot centres from the hip point
    in base axes, in [m]. reachable: (k,) which are in kinematic range, angles: (m, 3) of those, in [rad].
    feasible: (k,) which are footholds.
    """

    local_map: LocalMap
    tilt: Array
    cells: NDArray[np.intp]
    feet: Array
    reachable: NDArray[np.bool_]
    angles: Array
    feasible: NDArray[np.bool_]


def time_stages(
    oracle: Oracle, cases: Sequence[Case], naive_cells: int, margin_cells: int, seed: int
) -> dict[str, Any]:
    """`oracle_us_per_cell`: for each stage the mean time of `fast` (a whole map at once) and `naive` (one by one).

    naive_cells: how many cells of each case go through the naive way.
    margin_cells: how many cells in all, one of a case, go through its search for the margin, which takes seconds.
    """
    fast, naive = _FastStages(oracle.robot), _NaiveStages(oracle.robot)
    rng = np.random.default_rng(seed)
    spent: dict[str, Counter[str]] = {"fast": Counter(), "naive": Counter()}
    done: dict[str, Counter[str]] = {"fast": Counter(), "naive": Counter()}
    for number, case in enumerate(with_progress(cases, "stages")):
        work = _work(oracle, case)
        for way, stages in (
            ("fast", fast.of(work)),
            ("naive", naive.of(work, naive_cells, number < margin_cells, rng)),
        ):
            for stage, (call, cells) in stages.items():
                if cells:
                    spent[way][stage] += milliseconds(call)  # type: ignore[assignment]
                    done[way][stage] += cells
    names = list(done["fast"])
    return {
        "oracle_us_per_cell": {
            stage: {way: round(1e3 * spent[way][stage] / max(done[way][stage], 1), 3) for way in spent}
            for stage in names
        }
    }


def _work(oracle: Oracle, case: Case) -> Work:
    robot = oracle.robot
    local_map = robot.layout.local_map(case.elevation_map, case.pose, LEG)
    label = oracle.label(local_map, LEG, case.pose.roll, case.pose.pitch)
    tilt = tilt_rotation(case.pose.roll, case.pose.pitch)
    known = local_map.known
    contacts = np.column_stack([cell_offsets(local_map.cells, local_map.resolution)[known], local_map.heights[known]])
    feet = (contacts + np.array([0.0, 0.0, robot.description.foot_radius])) @ tilt
    angles, reachable = robot.kinematics[LEG].inverse(feet)
    feasible = label.reason[known] == Reason.FEASIBLE
    return Work(local_map, tilt, np.argwhere(known), feet, reachable, angles[reachable], feasible)


class _FastStages:
    """The parts of the fast oracle, taken apart to be timed."""

    def __init__(self, robot: Robot) -> None:
        self._kinematics = robot.kinematics[LEG]
        self._tables = load_tables(robot, LEG)
        self._exact = ExactSelfCollision(robot, LEG)
        self._terrain = TerrainCollision(SwingBodies.of(robot, LEG, robot.bodies[LEG].trimmed))

    def of(self, work: Work) -> Stages:
        heights, resolution = work.local_map.heights.astype(np.float64), work.local_map.resolution
        return {
            "kinematic_range": (lambda: self._kinematics.inverse(work.feet), len(work.feet)),
            "self_collision": (lambda: self._self_collisions(work.angles), len(work.angles)),
            "terrain_collision": (
                lambda: self._terrain.check(Terrain(heights, resolution), work.tilt, work.angles),
                len(work.angles),
            ),
            "kinematic_margin": (
                lambda: self._tables.margin.look_up(work.feet[work.feasible]),
                int(work.feasible.sum()),
            ),
            "terrain_cost": (lambda: terrain_costs(heights, resolution), len(work.feet)),
        }

    def _self_collisions(self, angles: Array) -> None:
        answers = self._tables.self_collision.look_up(angles)
        self._exact.check(angles[answers == UNDECIDED])


class _NaiveStages:
    """The same cell by cell: numeric inverse kinematics, every pair of bodies asked, the margin searched."""

    def __init__(self, robot: Robot) -> None:
        self._oracle = BruteForceOracle(robot, LEG)

    def of(self, work: Work, count: int, search_margin: bool, rng: np.random.Generator) -> Stages:
        oracle, local_map, tilt = self._oracle, work.local_map, work.tilt
        known = rng.choice(len(work.feet), min(count, len(work.feet)), replace=False)
        angles = work.angles[rng.choice(len(work.angles), min(count, len(work.angles)), replace=False)]
        feasible = rng.permutation(np.flatnonzero(work.feasible))[: int(search_margin)]
        feasible_angles = work.angles[(np.cumsum(work.reachable) - 1)[feasible]]
        cells = [(int(i), int(j)) for i, j in work.cells[known]]
        return {
            "kinematic_range": (lambda: [oracle.inverse(foot) for foot in work.feet[known]], len(known)),
            "self_collision": (lambda: [oracle.self_contact(q) for q in angles], len(angles)),
            "terrain_collision": (lambda: [oracle.terrain_contact(q, local_map, tilt) for q in angles], len(angles)),
            "kinematic_margin": (
                lambda: [oracle.margin(*pair) for pair in zip(work.feet[feasible], feasible_angles, strict=True)],
                len(feasible),
            ),
            "terrain_cost": (lambda: [terrain_cost(local_map, cell) for cell in cells], len(cells)),
        }
