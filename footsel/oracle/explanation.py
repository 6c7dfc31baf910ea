"""Why a cell has its label, in words and numbers: what its leg looks like there and which two bodies meet.

explainer = LegExplainer(oracle.robot, "LF")
print(explainer.cell(label, local_map, roll, pitch, (12, 30)))
explainer.contacts(label, local_map, roll, pitch).between(12, 30)  # ("LF_SHANK_0", "terrain")
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.errors import InputError
from footsel.footholds.pose import heading_rotation, tilt_rotation
from footsel.footholds.reasons import Reason
from footsel.legs import check_leg
from footsel.oracle.labeler import Label
from footsel.oracle.self_collision import ExactSelfCollision
from footsel.oracle.swing_bodies import SwingBodies
from footsel.oracle.terrain_collision import Terrain, TerrainCollision
from footsel.robot.description import JOINT_KINDS
from footsel.robot.robot import Robot
from footsel.terrain import LocalMap
from footsel.terrain.local_map import cell_offsets

#: What a leg meets that is no body of the robot.
TERRAIN = "terrain"

Pair = tuple[str, str]


@dataclass(frozen=True, eq=False)
class Contacts:
    """Which two bodies meet in every cell that collides.

    body_names: names of the collision bodies as in the URDF, and "terrain"; the first is empty.
    touching: (n, n, 2) uint8 indexing body_names: the swing leg's body and what it meets; 0 where nothing collides.
        Where several pairs meet, the first in the order of the URDF.
    """

    body_names: tuple[str, ...]
    touching: NDArray[np.uint8]

    def between(self, i: int, j: int) -> Pair | None:
        """The two bodies that meet in a cell, None if it collides with nothing."""
        swing, other = self.touching[i, j].tolist()
        return (self.body_names[swing], self.body_names[other]) if swing else None

    def pairs(self) -> dict[Pair, int]:
        """How many cells each pair decides, the commonest first."""
        met, counts = np.unique(self.touching[self.touching[..., 0] > 0], axis=0, return_counts=True)
        found = {
            (self.body_names[swing], self.body_names[other]): count
            for (swing, other), count in zip(met.tolist(), counts.tolist(), strict=True)
        }
        return dict(sorted(found.items(), key=lambda item: (-item[1], item[0])))


@dataclass(frozen=True, eq=False)
class CellExplanation:
    """One cell, explained; `str()` puts it into words.

    leg: whose local map it is. cell: (i, j). position: (3,) contact point in the world, z NaN if unknown, in [m].
    reason: the first constraint that fails, or FEASIBLE. cost: as in the label.
    margin: kinematic margin in [m], NaN if infeasible. margin_max: the largest of this leg, in [m].
    terrain_cost: c_m in [0, 1], NaN if unknown.
    joint_angles: (3,) HAA HFE KFE in [rad]; NaN beyond the leg's reach, outside `limits` beyond a joint's range.
    limits: (3, 2) of the joints, in [rad].
    foot_distance: from the hip point to the foot's centre, in [m].
    touching: every pair of bodies that meets, for the constraint that decided.
    """

    leg: str
    cell: tuple[int, int]
    position: NDArray[np.float64]
    reason: Reason
    cost: float
    margin: float
    margin_max: float
    terrain_cost: float
    joint_angles: NDArray[np.float64]
    limits: NDArray[np.float64]
    foot_distance: float
    touching: tuple[Pair, ...]

    def __str__(self) -> str:
        x, y, z = self.position
        lines = [f"{self.leg} cell {self.cell[0]} {self.cell[1]} at x={x:.3f} y={y:.3f} z={z:.3f} m: {self._verdict()}"]
        if self.reason != Reason.UNKNOWN:
            lines += [f"  joint angles: {self._angles()}", f"  kinematic margin: {self._margin()}"]
            lines += [f"  terrain cost: {self.terrain_cost:.3f} of 1"]
        return "\n".join(lines)

    @property
    def broken_limits(self) -> tuple[str, ...]:
        """Joints whose limits the foothold breaks, in words; none if the leg does not reach so far at all."""
        return tuple(
            f"{joint} would be {angle:.3f} rad, its range is {low:.3f} to {high:.3f}"
            for joint, angle, (low, high) in zip(JOINT_KINDS, self.joint_angles, self.limits, strict=True)
            if angle < low or angle > high
        )

    def _verdict(self) -> str:
        if self.reason == Reason.FEASIBLE:
            return f"feasible, cost {self.cost:.1f} of 255"
        if self.reason == Reason.UNKNOWN:
            return "unknown, the map has no elevation here"
        if self.reason == Reason.KINEMATIC_RANGE:
            why = (
                "; ".join(self.broken_limits) or f"no pose reaches {self.foot_distance:.3f} m from the hip point there"
            )
            return f"out of kinematic range: {why}"
        kind = "self-collision" if self.reason == Reason.SELF_COLLISION else "terrain collision"
        met = ", ".join(f"{swing} against {other}" for swing, other in self.touching)
        return f"{kind}: {met or 'two bodies graze, nearer than rounding tells'}"

    def _angles(self) -> str:
        known = [
            f"{joint} {angle:+.3f}"
            for joint, angle in zip(JOINT_KINDS, self.joint_angles, strict=True)
            if not np.isnan(angle)
        ]
        return ", ".join(known) + " rad" if len(known) == len(JOINT_KINDS) else "none"

    def _margin(self) -> str:
        if np.isnan(self.margin):
            return "none, the foothold is infeasible"
        return f"{self.margin:.4f} m of {self.margin_max:.4f} m at most"


class LegExplainer:
    """Explains labels of one leg; asks coal afresh at the label's joint angles, some 30 us a cell."""

    def __init__(self, robot: Robot, leg: str) -> None:
        self._robot = robot
        self._leg = check_leg(leg)
        self._kinematics = robot.kinematics[leg]
        bodies = robot.bodies[leg]
        self._self_collision = ExactSelfCollision(robot, leg)
        self._terrain_collision = TerrainCollision(SwingBodies.of(robot, leg, bodies.trimmed))
        names = dict.fromkeys(body.name for body in (*bodies.swing, *bodies.trimmed, *bodies.obstacles))
        self._body_names = ("", *names, TERRAIN)

    def contacts(self, label: Label, local_map: LocalMap, roll: float, pitch: float) -> Contacts:
        """The bodies that meet in every colliding cell of a label of this leg, the base tilted as it was then [rad]."""
        touching = np.zeros((*label.reason.shape, 2), dtype=np.uint8)
        terrain, tilt = _terrain_of(local_map), tilt_rotation(roll, pitch)
        index = {name: number for number, name in enumerate(self._body_names)}
        for i, j in np.argwhere(np.isin(label.reason, [Reason.SELF_COLLISION, Reason.TERRAIN_COLLISION])).tolist():
            pairs = self._touching(Reason(int(label.reason[i, j])), terrain, tilt, label.joint_angles[i, j])
            if pairs:
                touching[i, j] = [index[name] for name in pairs[0]]
        return Contacts(self._body_names, touching)

    def cell(
        self, label: Label, local_map: LocalMap, roll: float, pitch: float, cell: tuple[int, int]
    ) -> CellExplanation:
        """One cell (i, j) of a label of this leg, the base tilted as it was then [rad]. InputError if off the map."""
        i, j = cell
        if not (0 <= i < local_map.cells and 0 <= j < local_map.cells):
            raise InputError(
                f"cell {i} {j} is not on the local map", f"cells are 0 0 to {(n := local_map.cells - 1)} {n}"
            )
        offset = cell_offsets(local_map.cells, local_map.resolution)[i, j]
        height = float(local_map.heights[i, j])
        contact = np.array([*offset, height + self._robot.layout.foot_radius])
        tilt = tilt_rotation(roll, pitch)
        reason = Reason(int(label.reason[i, j]))
        angles = label.joint_angles[i, j]
        if reason == Reason.KINEMATIC_RANGE:
            angles = self._kinematics.inverse(contact @ tilt)[0][0]
        return CellExplanation(
            leg=self._leg,
            cell=(i, j),
            position=local_map.positions()[i, j],
            reason=reason,
            cost=float(label.cost[i, j]),
            margin=float(label.kinematic_margin[i, j]),
            margin_max=self._robot.margin_max(self._leg),
            terrain_cost=float(label.terrain_cost[i, j]),
            joint_angles=angles,
            limits=self._kinematics.limits,
            foot_distance=float(np.linalg.norm(contact)),
            touching=tuple(self._touching(reason, _terrain_of(local_map), tilt, angles)),
        )

    def _touching(
        self, reason: Reason, terrain: Terrain, tilt: NDArray[np.float64], angles: NDArray[np.float64]
    ) -> list[Pair]:
        """Every pair that meets, in the URDF's order; asked of the constraint that decided."""
        if reason == Reason.SELF_COLLISION:
            return self._self_collision.touching(angles)
        if reason == Reason.TERRAIN_COLLISION:
            return [(name, TERRAIN) for name in self._terrain_collision.touching(terrain, tilt, angles)]
        return []


def cell_at(local_map: LocalMap, x: float, y: float) -> tuple[int, int]:
    """The cell of a local map that a world point falls in, in [m]. InputError if it falls in none."""
    along = (heading_rotation(local_map.yaw)[:2, :2].T @ (np.array([x, y]) - local_map.hip[:2])) / local_map.resolution
    i, j = np.floor(along + local_map.cells / 2).astype(int).tolist()
    if not (0 <= i < local_map.cells and 0 <= j < local_map.cells):
        half = local_map.cells * local_map.resolution / 2
        raise InputError(
            f"x={x:g} y={y:g} is not on the local map",
            f"it reaches {half:g} m to each side of x={local_map.hip[0]:.3f} y={local_map.hip[1]:.3f}",
        )
    return i, j


def _terrain_of(local_map: LocalMap) -> Terrain:
    return Terrain(local_map.heights.astype(np.float64), local_map.resolution)
