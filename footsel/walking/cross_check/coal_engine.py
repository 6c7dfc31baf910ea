"""coal with the URDF's primitives on a height field, as the oracle has it, or with full meshes on triangles."""

from typing import Any

import coal
import numpy as np
import pinocchio as pin

from footsel.oracle.terrain_collision import Terrain
from footsel.robot.collision_geometry import Body, LegBodies
from footsel.robot.robot import Robot, stance_configuration
from footsel.terrain import LocalMap
from footsel.walking.cross_check.engine import NO_SHIFT, Engine, Vector
from footsel.walking.cross_check.terrain_mesh import TerrainMesh, triangle_model


class CoalEngine(Engine):
    """Every allowed pair is put to coal afresh, the leg placed by Pinocchio."""

    def __init__(self, robot: Robot, leg: str, bodies: LegBodies | None = None) -> None:
        """bodies: meshes in place of the URDF's primitives; they meet a triangle mesh in place of a height field."""
        self._robot, self._bodies, self._meshes = robot, bodies or robot.bodies[leg], bodies is not None
        self._data = robot.model.createData()
        self._configuration = stance_configuration(robot.description, robot.model)
        self._joints = [robot.model.getJointId(name) for name in robot.description.joints[leg]]
        self._angles = [robot.model.joints[joint].idx_q for joint in self._joints]
        self._hip = robot.layout.hips[leg]

    def stand(self, local_map: LocalMap, tilt: Vector) -> None:
        """Put the base over a terrain."""
        self._base = pin.SE3(tilt, -tilt @ self._hip)
        self._mesh = TerrainMesh.of(local_map)
        self._triangles = triangle_model(self._mesh.vertices, self._mesh.triangles)
        field = Terrain(local_map.heights.astype(np.float64), local_map.resolution).field
        self._ground = self._triangles if self._meshes else field

    def self_contacts(self, angles: Vector, shift: Vector = NO_SHIFT) -> list[tuple[str, str]]:
        """Pairs that touch."""
        swing, others = self._swing(angles, shift), self._others()
        return [
            (swing[i][0].name, others[j][0].name)
            for i, j in self._bodies.pairs
            if _touch(swing[i][0].shape, swing[i][1], others[j][0].shape, others[j][1])
        ]

    def terrain_contacts(self, angles: Vector, shift: Vector = NO_SHIFT) -> list[str]:
        """Bodies that touch; a mesh also if it cuts no triangle and lies under the ground."""
        still = coal.Transform3s.Identity()
        placed = self._trimmed(angles, shift)
        buried = np.zeros(len(placed), dtype=bool)
        if self._meshes:
            centres = [at.getRotation() @ body.shape.aabb_center + at.getTranslation() for body, at in placed]
            buried = self._mesh.below(np.array(centres))
        return [
            body.name
            for (body, at), under in zip(placed, buried.tolist(), strict=True)
            if under or _touch(body.shape, at, self._ground, still)
        ]

    def clearance(self, kind: str, angles: Vector) -> tuple[float, tuple[str, str]]:
        """The least distance of two bodies that may not touch, in [m], and which they are; for a leg that is free."""
        if kind == "terrain":
            ground = self._triangles, coal.Transform3s.Identity()
            return min(
                (_distance(body.shape, at, *ground), (body.name, "terrain"))
                for body, at in self._trimmed(angles, NO_SHIFT)
            )
        swing, others = self._swing(angles, NO_SHIFT), self._others()
        return min(
            (
                _distance(swing[i][0].shape, swing[i][1], others[j][0].shape, others[j][1]),
                (swing[i][0].name, others[j][0].name),
            )
            for i, j in self._bodies.pairs
        )

    def _swing(self, angles: Vector, shift: Vector) -> list[tuple[Body, Any]]:
        return self._placed(self._bodies.swing, angles, shift)

    def _trimmed(self, angles: Vector, shift: Vector) -> list[tuple[Body, Any]]:
        return self._placed(self._bodies.trimmed, angles, shift)

    def _placed(self, bodies: tuple[Body, ...], angles: Vector, shift: Vector) -> list[tuple[Body, Any]]:
        self._configuration[self._angles] = angles
        pin.forwardKinematics(self._robot.model, self._data, self._configuration)
        links = [self._base * self._data.oMi[joint] for joint in self._joints]
        return [(body, _transform(links[body.joint - 1] * _placement(body), shift)) for body in bodies]

    def _others(self) -> list[tuple[Body, Any]]:
        return [(body, _transform(self._base * _placement(body), NO_SHIFT)) for body in self._bodies.obstacles]


def _placement(body: Body) -> Any:
    return pin.SE3(body.rotation, body.translation)


def _transform(placement: Any, shift: Vector) -> Any:
    return coal.Transform3s(placement.rotation, placement.translation + shift)


def _touch(shape_a: Any, placed_a: Any, shape_b: Any, placed_b: Any) -> bool:
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    return bool(coal.collide(shape_a, placed_a, shape_b, placed_b, request, result))


def _distance(shape_a: Any, placed_a: Any, shape_b: Any, placed_b: Any) -> float:
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return float(coal.distance(shape_a, placed_a, shape_b, placed_b, request, result))
