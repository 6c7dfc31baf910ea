"""The oracle: five constraints in sequence for every cell of a local map (section III-A of the paper)."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.cost import INFEASIBLE_COST, foothold_cost
from footsel.footholds.pose import tilt_rotation
from footsel.footholds.reasons import Reason
from footsel.legs import check_leg
from footsel.oracle.overlap import COLLIDES, UNDECIDED
from footsel.oracle.self_collision import ExactSelfCollision
from footsel.oracle.swing_bodies import SwingBodies
from footsel.oracle.tables import load_tables
from footsel.oracle.terrain_collision import Terrain, TerrainCollision
from footsel.oracle.terrain_cost import terrain_costs
from footsel.robot.robot import Robot, load_robot
from footsel.terrain import LocalMap
from footsel.terrain.local_map import cell_offsets


@dataclass(frozen=True, eq=False)
class Label:
    """What the oracle says of every cell of a local map.

    cost: (n, n) float64 in [0, 254] where feasible, 255 elsewhere.
    reason: (n, n) uint8 Reason.
    kinematic_margin: (n, n) where feasible, NaN elsewhere, in [m].
    terrain_cost: (n, n) c_m in [0, 1] of every known cell, NaN elsewhere.
    joint_angles: (n, n, 3) HAA HFE KFE where in kinematic range, NaN elsewhere, in [rad].
    """

    cost: NDArray[np.float64]
    reason: NDArray[np.uint8]
    kinematic_margin: NDArray[np.float64]
    terrain_cost: NDArray[np.float64]
    joint_angles: NDArray[np.float64]

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """(n, n) which cells are footholds."""
        return np.asarray(self.reason == Reason.FEASIBLE)

    @property
    def cost_image(self) -> NDArray[np.uint8]:
        """(n, n) cost rounded to 8 bits, as it is stored; 255 stays for infeasible cells alone."""
        return np.rint(self.cost).astype(np.uint8)


class LegOracle:
    """The oracle of one leg.

    Of a symmetric robot, a right leg looks its angles and foot positions up in the mirrored tables of the left one. All
    else is its own, terrain above all: a mirrored height field would split its quads along the other diagonal.
    """

    def __init__(self, robot: Robot, leg: str) -> None:
        self._robot = robot
        self._leg = leg
        self._kinematics = robot.kinematics[leg]
        self._tables = load_tables(robot, robot.table_leg(leg))
        mirrored = robot.table_leg(leg) != leg
        self._angle_signs = np.array([-1.0, 1.0, 1.0]) if mirrored else np.ones(3)
        self._position_signs = np.array([1.0, -1.0, 1.0]) if mirrored else np.ones(3)
        self._exact_self_collision = ExactSelfCollision(robot, leg)
        self._terrain_collision = TerrainCollision(SwingBodies.of(robot, leg, robot.bodies[leg].trimmed))
        self._margin_max = robot.margin_max(leg)
        self._foot = np.array([0.0, 0.0, robot.description.foot_radius])

    def label(self, heights: NDArray[np.floating], resolution: float, roll: float, pitch: float) -> Label:
        """Label a local map of heights (n, n) relative to the hip point, NaN = unknown, in [m]."""
        exact: NDArray[np.float64] = np.asarray(heights, dtype=np.float64)
        cells = len(exact)
        known = ~np.isnan(exact)
        reason = np.where(known, Reason.KINEMATIC_RANGE, Reason.UNKNOWN).astype(np.uint8)
        cost = np.full(exact.shape, float(INFEASIBLE_COST))
        margin = np.full(exact.shape, np.nan)
        joint_angles = np.full((*exact.shape, 3), np.nan)
        terrain_cost = terrain_costs(exact, resolution)

        candidates = np.argwhere(known)
        contacts = np.column_stack([cell_offsets(cells, resolution)[known], exact[known]])
        tilt = tilt_rotation(roll, pitch)
        # A row vector times the rotation from base to heading frame is that vector in the base frame.
        feet = (contacts + self._foot) @ tilt
        angles, reachable = self._kinematics.inverse(feet)
        candidates, feet, angles = candidates[reachable], feet[reachable], angles[reachable]
        joint_angles[tuple(candidates.T)] = angles

        touches = self._self_collides(angles)
        reason[tuple(candidates[touches].T)] = Reason.SELF_COLLISION
        candidates, feet, angles = candidates[~touches], feet[~touches], angles[~touches]

        if len(candidates):
            touches = self._terrain_collision.check(Terrain(exact, resolution), tilt, angles)
            reason[tuple(candidates[touches].T)] = Reason.TERRAIN_COLLISION
            candidates, feet = candidates[~touches], feet[~touches]

        where = tuple(candidates.T)
        reason[where] = Reason.FEASIBLE
        margin[where] = self._tables.margin.look_up(feet * self._position_signs)
        margin_cost = 1 - np.minimum(margin[where], self._margin_max) / self._margin_max
        cost[where] = foothold_cost(margin_cost, terrain_cost[where])
        return Label(cost, reason, margin, terrain_cost, joint_angles)

    def _self_collides(self, angles: NDArray[np.float64]) -> NDArray[np.bool_]:
        answers = self._tables.self_collision.look_up(angles * self._angle_signs)
        collides = np.asarray(answers == COLLIDES)
        undecided = answers == UNDECIDED
        collides[undecided] = self._exact_self_collision.check(angles[undecided])
        return collides


class Oracle:
    """The exact answer for all four legs of a robot."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._legs: dict[str, LegOracle] = {}

    @classmethod
    def load(cls, name: str = "anymal_b") -> "Oracle":
        """The oracle of a robot by name; its tables are made on first use."""
        return _oracle_of(load_robot(name))

    def label(self, local_map: LocalMap, leg: str, roll: float = 0.0, pitch: float = 0.0) -> Label:
        """Label every cell of a leg's local map. Roll and pitch of the base in [rad]."""
        if check_leg(leg) not in self._legs:
            self._legs[leg] = LegOracle(self.robot, leg)
        return self._legs[leg].label(local_map.heights, local_map.resolution, roll, pitch)


@cache
def _oracle_of(robot: Robot) -> Oracle:
    return Oracle(robot)
