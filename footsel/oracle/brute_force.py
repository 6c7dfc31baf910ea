"""The label of a cell by its definition: what the fast oracle must equal, written to be read and not to be quick.

One cell at a time, without tables, prefilters or closed forms. It shares the robot description with the fast oracle and
nothing else: inverse kinematics is numeric (Pinocchio's Jacobian), every pair of bodies is put to coal, and the
kinematic margin is searched direction by direction. It is also the naive baseline of `footsel bench`.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.linalg import lapack

from footsel.footholds.cost import INFEASIBLE_COST, foothold_cost
from footsel.footholds.pose import tilt_rotation
from footsel.footholds.reasons import Reason
from footsel.legs import check_leg
from footsel.oracle.brute_force_terrain import terrain_cost
from footsel.robot.robot import Robot, stance_configuration
from footsel.terrain import LocalMap

Vector = NDArray[np.float64]

#: A foot centre this near to its target has reached it; iteration goes on to the goal, near machine precision. [m]
POSITION_TOLERANCE = 1e-7
POSITION_GOAL = 1e-13
#: A descent ends when an iteration leaves more than this share of the squared error.
STAGNATION = 0.99
MAX_ITERATIONS = 60
#: The least damping: keeps a step from a singular configuration finite.
SINGULAR_DAMPING = 1e-12
#: Seeds beside the nominal stance: these fractions of each joint's range, where they lie on its branch. They reach into
#: the corners of the range: ten seeds nearer its middle missed 17 of 44,000 configurations.
SEED_FRACTIONS = ((0.05, 0.95), (0.15, 0.35, 0.65, 0.85), (0.1, 0.5, 0.9))
#: Joint angles this far beyond a limit are within it (rounding), in [rad].
ANGLE_TOLERANCE = 1e-9

#: The margin search: so many directions are marched from the foot itself; further ones begin where the directions
#: before them have spread further apart than the spacing. Step of the march, its bisection. [m]
LEAST_DIRECTIONS = 200
SPACING = 0.015
MARCH_STEP = 0.0025
BISECTION_TOLERANCE = 5e-5
#: The nearest hits are refined on rings of these angles around their directions, in [rad].
REFINED_DIRECTIONS = 4
RING_ANGLES = (0.08, 0.04, 0.02, 0.01, 0.005)
RING_SIZE = 8
#: A refined direction is marched over this last part of its length, in [m].
RING_DEPTH = 0.01

#: Unknown cells are lowered to this depth below the lowest known cell, out of the way of every leg, in [m].
FLOOR_DEPTH = 1.0


@dataclass(frozen=True, eq=False)
class CellLabel:
    """The label of one cell.

    reason: the first constraint that the cell fails, or FEASIBLE.
    cost: in [0, 254] if feasible, else 255; NaN if feasible and the margin was not asked for.
    margin: distance of the foot's centre to the border of its workspace, in [m]; NaN if infeasible or not asked for.
    terrain_cost: c_m in [0, 1]; NaN if the cell is unknown.
    joint_angles: (3,) HAA HFE KFE in [rad]; None if the cell is unknown or out of range.
    touching: the leg's body and what it meets, the first pair found; None if nothing collides.
    """

    reason: Reason
    cost: float
    margin: float
    terrain_cost: float
    joint_angles: Vector | None
    touching: tuple[str, str] | None = None


def brute_force_cell(
    robot: Robot,
    local_map: LocalMap,
    leg: str,
    roll: float,
    pitch: float,
    cell: tuple[int, int],
    with_margin: bool = True,
) -> CellLabel:
    """The label of one cell (i, j) of the local map of a leg, the base tilted by roll and pitch in [rad]."""
    return _oracle(robot, leg).label_cell(local_map, roll, pitch, cell, with_margin)


class BruteForceOracle:
    """The label of one leg's cells, the rest of the robot frozen in its nominal stance.

    Positions of the foot's centre are relative to the hip point L_i in the base frame, in [m].
    """

    def __init__(self, robot: Robot, leg: str) -> None:
        self.robot, self.leg = robot, check_leg(leg)
        description, bodies = robot.description, robot.bodies[leg]
        stance = stance_configuration(description, robot.model)
        own = description.joints[leg]
        frozen = [index for index, name in enumerate(robot.model.names) if index > 0 and name not in own]
        self._model, self._geometry = pin.buildReducedModel(robot.model, robot.geometry, frozen, stance)
        self._geometry.removeAllCollisionPairs()
        for swing, obstacle in bodies.pairs:
            pair = bodies.swing[swing].name, bodies.obstacles[obstacle].name
            self._geometry.addCollisionPair(pin.CollisionPair(*map(self._geometry.getGeometryId, pair)))
        self._data, self._geometry_data = self._model.createData(), self._geometry.createData()
        self._joints = [self._model.getJointId(name) for name in own]
        self._foot = self._model.getFrameId(robot.model.frames[robot.foot_frames[leg]].name)
        self._low, self._high = np.array(description.limits[leg]).T
        fractions = np.stack(np.meshgrid(*SEED_FRACTIONS, indexing="ij"), axis=-1).reshape(-1, 3)
        self._seeds = [np.array(description.stance[leg])]
        self._seeds += [seed for seed in self._low + fractions * (self._high - self._low) if self._on_branch(seed)]
        self._terrain: tuple[LocalMap, Any] | None = None

    def label(
        self, local_map: LocalMap, roll: float, pitch: float, with_margin: bool = False
    ) -> tuple[NDArray[np.uint8], Vector]:
        """Reason and cost (n, n) of every cell, one after another, as `label_cell` gives them.

        With margins this takes over a second for each feasible cell.
        """
        reason, cost = np.zeros(local_map.heights.shape, dtype=np.uint8), np.zeros(local_map.heights.shape)
        for i in range(local_map.cells):
            for j in range(local_map.cells):
                label = self.label_cell(local_map, roll, pitch, (i, j), with_margin)
                reason[i, j], cost[i, j] = label.reason, label.cost
        return reason, cost

    def label_cell(
        self, local_map: LocalMap, roll: float, pitch: float, cell: tuple[int, int], with_margin: bool = True
    ) -> CellLabel:
        """The label of one cell (i, j) of this leg's local map, the base tilted by roll and pitch in [rad]."""
        i, j = cell
        middle, d = (local_map.cells - 1) / 2, local_map.resolution
        contact = np.array([(i - middle) * d, (j - middle) * d, local_map.heights[i, j]])
        if np.isnan(contact[2]):
            return CellLabel(Reason.UNKNOWN, INFEASIBLE_COST, np.nan, np.nan, None)
        c_m = terrain_cost(local_map, cell)
        tilt = tilt_rotation(roll, pitch)
        centre = tilt.T @ (contact + np.array([0.0, 0.0, self.robot.description.foot_radius]))
        angles = self.inverse(centre)
        if angles is None:
            return CellLabel(Reason.KINEMATIC_RANGE, INFEASIBLE_COST, np.nan, c_m, None)
        if pair := self.self_contact(angles):
            return CellLabel(Reason.SELF_COLLISION, INFEASIBLE_COST, np.nan, c_m, angles, pair)
        if body := self.terrain_contact(angles, local_map, tilt):
            return CellLabel(Reason.TERRAIN_COLLISION, INFEASIBLE_COST, np.nan, c_m, angles, (body, "terrain"))
        if not with_margin:
            return CellLabel(Reason.FEASIBLE, np.nan, np.nan, c_m, angles)
        margin, margin_max = self.margin(centre, angles), self.robot.margin_max(self.leg)
        c_k = 1 - min(margin, margin_max) / margin_max
        return CellLabel(Reason.FEASIBLE, float(foothold_cost(c_k, c_m)), margin, c_m, angles)

    def forward(self, angles: Vector) -> Vector:
        """(3,) foot centre for HAA HFE KFE in [rad]."""
        pin.forwardKinematics(self._model, self._data, angles)
        foot = pin.updateFramePlacement(self._model, self._data, self._foot)
        return np.asarray(foot.translation - self.robot.layout.hips[self.leg])

    def inverse(self, centre: Vector) -> Vector | None:
        """Angles (3,) within the limits, on the nominal stance's branch, that put the foot on `centre`; None if none.

        A descent that ends on another branch or beyond a limit does not count, and the next seed is tried.
        """
        for seed in self._seeds:
            angles = self._descend(seed, centre)
            if angles is not None and self._on_branch(angles) and self._within_limits(angles):
                return angles
        return None

    def _descend(self, seed: Vector, centre: Vector) -> Vector | None:
        """Angles that put the foot on `centre`, from one seed; None if the descent ends elsewhere.

        Levenberg-Marquardt, damped by the squared error (Sugihara 2011, IEEE Transactions on Robotics 27).
        """
        angles, target = seed, centre + self.robot.layout.hips[self.leg]
        previous = np.inf
        for _ in range(MAX_ITERATIONS):
            jacobian = pin.computeFrameJacobian(self._model, self._data, angles, self._foot, pin.LOCAL_WORLD_ALIGNED)[
                :3
            ]
            error = target - pin.updateFramePlacement(self._model, self._data, self._foot).translation
            square = error @ error
            if square < POSITION_GOAL**2 or square > STAGNATION * previous:
                break
            previous = square
            hessian = jacobian.T @ jacobian
            hessian.flat[::4] += square + SINGULAR_DAMPING
            # LAPACK's Cholesky solution of the positive definite system, without NumPy's checks around it.
            angles = angles + lapack.dposv(hessian, jacobian.T @ error)[1]
        return np.pi - (np.pi - angles) % (2 * np.pi) if square < POSITION_TOLERANCE**2 else None

    def _within_limits(self, angles: Vector) -> bool:
        return bool((angles >= self._low - ANGLE_TOLERANCE).all() and (angles <= self._high + ANGLE_TOLERANCE).all())

    def _on_branch(self, angles: Vector) -> bool:
        """Whether the foot is below the HFE axis along the z axis of the HAA link; the limits fix the knee's side."""
        pin.forwardKinematics(self._model, self._data, angles)
        foot = pin.updateFramePlacement(self._model, self._data, self._foot)
        haa, hfe = (self._data.oMi[joint] for joint in self._joints[:2])
        return bool(haa.rotation[:, 2] @ (foot.translation - hfe.translation) < 0)

    def self_contact(self, angles: Vector) -> tuple[str, str] | None:
        """The first pair of bodies in which the swing leg touches the base or another leg, None if there is none.

        Every pair is asked afresh: with what coal keeps from one question to the next, as Pinocchio's computeCollisions
        lets it, one overlap in some hundred thousand is missed.
        """
        pin.updateGeometryPlacements(self._model, self._data, self._geometry, self._geometry_data, angles)
        bodies = self._geometry.geometryObjects
        placed = [coal.Transform3s(place.rotation, place.translation) for place in self._geometry_data.oMg]
        for i, j in ((pair.first, pair.second) for pair in self._geometry.collisionPairs):
            request, result = coal.CollisionRequest(), coal.CollisionResult()
            if coal.collide(bodies[i].geometry, placed[i], bodies[j].geometry, placed[j], request, result):
                return bodies[i].name, bodies[j].name
        return None

    def _quickly_self_collides(self, angles: Vector) -> bool:
        """As `self_contact`, ten times as fast: a search asks thousands of times, and a miss hardly moves a border."""
        return bool(pin.computeCollisions(self._model, self._data, self._geometry, self._geometry_data, angles, True))

    def terrain_contact(self, angles: Vector, local_map: LocalMap, tilt: Vector) -> str | None:
        """The first body of thigh or trimmed shank that touches the terrain, None if none does.

        tilt: (3, 3) rotation from the base frame to the heading frame.
        """
        if self._terrain is None or self._terrain[0] is not local_map:
            self._terrain = local_map, terrain_solid(local_map)
        terrain = self._terrain[1]
        pin.forwardKinematics(self._model, self._data, angles)
        heading = pin.SE3(tilt, -tilt @ self.robot.layout.hips[self.leg])
        request, still = coal.CollisionRequest(), coal.Transform3s.Identity()
        for body in self.robot.bodies[self.leg].trimmed:
            joint = self._data.oMi[self._joints[body.joint - 1]]
            placed = heading * joint * pin.SE3(body.rotation, body.translation)
            transform = coal.Transform3s(placed.rotation, placed.translation)
            if coal.collide(body.shape, transform, terrain, still, request, coal.CollisionResult()):
                return str(body.name)
        return None

    def margin(self, centre: Vector, angles: Vector) -> float:
        """Distance from a free foot centre to the nearest position out of range or in self-collision, in [m].

        The foot is marched in all directions up to the nearest hit; the nearest directions are then refined by turning
        them ever less. A part of the border thinner than the march or the spacing may be missed.
        """
        hits: list[tuple[float, list[float]]] = []
        nearest, index, start = np.inf, 0, 0.0
        while start < nearest:
            direction = _direction(index)
            length = self._free_length(centre, angles, direction, start, nearest + MARCH_STEP)
            if length < np.inf:
                hits.append((length, direction.tolist()))
                nearest = min(nearest, length)
            index += 1
            start = 0.0 if index < LEAST_DIRECTIONS else SPACING * np.sqrt(index / (4 * np.pi))
        best = [np.array(direction) for _, direction in sorted(hits)[:REFINED_DIRECTIONS]]
        return min(self._refined(centre, angles, direction) for direction in best)

    def _refined(self, centre: Vector, angles: Vector, direction: Vector) -> float:
        """The least free length near a direction, in [m]."""
        least = self._free_length(centre, angles, direction)
        for angle in RING_ANGLES:
            for neighbour in _ring(direction, angle):
                start = max(least - RING_DEPTH, 0.0)
                length = self._free_length(centre, angles, neighbour, start, least)
                if length < least:
                    least, direction = length, neighbour
        return least

    def _free_length(
        self, centre: Vector, angles: Vector, direction: Vector, start: float = 0.0, longest: float = np.inf
    ) -> float:
        """How far the foot moves along a unit direction until it is not free; inf if that is beyond `longest`. [m]

        The march begins at `start` if the foot is free there, else at the foot itself.
        """
        at_start = self._free_angles(centre + start * direction, angles)
        free, angles = (start, at_start) if at_start is not None else (0.0, angles)
        blocked = min(free + MARCH_STEP, longest)
        while (ahead := self._free_angles(centre + blocked * direction, angles)) is not None:
            if blocked >= longest:
                return np.inf
            free, blocked, angles = blocked, min(blocked + MARCH_STEP, longest), ahead
        while blocked - free > BISECTION_TOLERANCE:
            middle = (free + blocked) / 2
            ahead = self._free_angles(centre + middle * direction, angles)
            free, blocked, angles = (free, middle, angles) if ahead is None else (middle, blocked, ahead)
        return blocked

    def _free_angles(self, centre: Vector, neighbour: Vector) -> Vector | None:
        """The angles at a position of the self-collision-free workspace, None outside of it.

        neighbour: the angles of a free position next to it. What is followed from there is the one configuration of the
        branch at this position, so a limit that it breaks settles the matter; leaving the branch does not.
        """
        angles = self._descend(neighbour, centre)
        if angles is None or not self._on_branch(angles):
            angles = self.inverse(centre)
        elif not self._within_limits(angles):
            return None
        return None if angles is None or self._quickly_self_collides(angles) else angles


def terrain_solid(local_map: LocalMap) -> Any:
    """The terrain below the known cells as a coal height field in the heading frame; it ends at the outer cell centres.

    Rows of coal's matrix run down the y axis, columns up the x axis, and the heights are those of its vertices.
    """
    heights = local_map.heights.astype(np.float64)
    floor = np.nanmin(heights) - FLOOR_DEPTH
    side = (local_map.cells - 1) * local_map.resolution
    vertices = np.where(np.isnan(heights), floor, heights).T[::-1]
    return coal.HeightFieldOBBRSS(side, side, np.ascontiguousarray(vertices), floor)


@cache
def _oracle(robot: Robot, leg: str) -> BruteForceOracle:
    return BruteForceOracle(robot, leg)


def _direction(index: int) -> Vector:
    """Unit vector of a sequence that spreads evenly over the sphere, however far it is taken.

    Roberts' R2 sequence (2018), which generalises the golden ratio to two dimensions.
    """
    plastic = 1.32471795724474602596
    z = 1 - 2 * ((0.5 + index / plastic) % 1)
    turn = 2 * np.pi * (index / plastic**2 % 1)
    ring = np.sqrt(1 - z * z)
    return np.array([ring * np.cos(turn), ring * np.sin(turn), z])


def _ring(direction: Vector, angle: float) -> list[Vector]:
    """Unit vectors at an angle from a direction, evenly around it."""
    side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    side /= np.linalg.norm(side)
    other = np.cross(direction, side)
    turns = 2 * np.pi * np.arange(RING_SIZE) / RING_SIZE
    return [np.cos(angle) * direction + np.sin(angle) * (np.cos(t) * side + np.sin(t) * other) for t in turns]
