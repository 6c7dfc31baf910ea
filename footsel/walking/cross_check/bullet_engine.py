"""PyBullet with the URDF's primitives and a triangle mesh: its own parser, forward kinematics and contacts."""

from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.terrain import LocalMap
from footsel.walking.bullet import BulletWorld, pybullet
from footsel.walking.cross_check.engine import NO_SHIFT, Engine, Vector
from footsel.walking.cross_check.split_urdf import TRIMMED, split_urdf
from footsel.walking.cross_check.terrain_mesh import TerrainMesh


class BulletEngine(Engine):
    """Two copies of the robot: the leg of one is moved, base and other legs of the other stand at the nominal stance.

    Contacts are those of getClosestPoints at distance 0.
    """

    def __init__(self, robot: Robot, leg: str) -> None:
        self._world = BulletWorld()
        self._hip = robot.layout.hips[leg]
        bodies = robot.bodies[leg]
        joints = robot.description.joints[leg]
        cut = [body for body in bodies.trimmed if all(body.shape is not whole.shape for whole in bodies.swing)]
        with TemporaryDirectory() as folder:
            path = Path(folder) / "bodies.urdf"
            moved = _moved_links(robot.description.urdf_path)
            added = [(moved[joints[body.joint - 1]], body) for body in cut]
            path.write_text(split_urdf(robot.description.urdf_path, added), encoding="utf-8")
            self._moving, self._standing = (
                self._world.loadURDF(str(path), useFixedBase=True, flags=pybullet.URDF_USE_IMPLICIT_CYLINDER)
                for _ in range(2)
            )
        infos = [
            self._world.getJointInfo(self._moving, index) for index in range(self._world.getNumJoints(self._moving))
        ]
        joint_index = {info[1].decode(): info[0] for info in infos}
        self._link_index = {info[12].decode(): info[0] for info in infos}
        self._link_name = {index: name for name, index in self._link_index.items()}
        self._joints = [joint_index[name] for name in joints]
        for each in LEGS:
            for name, angle in zip(robot.description.joints[each], robot.description.stance[each], strict=True):
                for body in (self._moving, self._standing):
                    self._world.resetJointState(body, joint_index[name], angle)
        self._allowed = {(bodies.swing[i].name, bodies.obstacles[j].name) for i, j in bodies.pairs}
        self._swing = [body.name for body in bodies.swing]
        names = {body.name for body in cut}
        self._trimmed = {body.name: body.name + TRIMMED * (body.name in names) for body in bodies.trimmed}
        self._terrain: int | None = None

    def stand(self, local_map: LocalMap, tilt: Vector) -> None:
        """Put the base over a terrain."""
        if self._terrain is not None:
            self._world.removeBody(self._terrain)
        self._mesh = TerrainMesh.of(local_map)
        shape = self._world.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=self._mesh.vertices.tolist(),
            indices=self._mesh.triangles.ravel().tolist(),
            flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
        )
        self._terrain = self._world.createMultiBody(0, shape)
        self._origin, self._turn = -tilt @ self._hip, pin.Quaternion(tilt).coeffs()
        self._place(self._standing, NO_SHIFT)

    def self_contacts(self, angles: Vector, shift: Vector = NO_SHIFT) -> list[tuple[str, str]]:
        """Pairs that touch."""
        self._pose(angles, shift)
        found = []
        for name in self._swing:
            others = {self._link_name.get(point[4], "") for point in self._near(name, self._standing)}
            found += [(name, other) for other in sorted(others) if (name, other) in self._allowed]
        return found

    def terrain_contacts(self, angles: Vector, shift: Vector = NO_SHIFT) -> list[str]:
        """Bodies that cut a triangle or lie under the ground as a whole."""
        self._pose(angles, shift)
        assert self._terrain is not None
        centres = np.array([self._centre(link) for link in self._trimmed.values()])
        buried = self._mesh.below(centres)
        return [
            name
            for (name, link), under in zip(self._trimmed.items(), buried.tolist(), strict=True)
            if under or self._near(link, self._terrain)
        ]

    def close(self) -> None:
        """End PyBullet's world."""
        with suppress(pybullet.error):
            self._world.disconnect()

    def _near(self, link: str, other: int) -> list[Any]:
        points = self._world.getClosestPoints(self._moving, other, 0.0, linkIndexA=self._link_index[link])
        return [point for point in points if point[8] <= 0]

    def _centre(self, link: str) -> Vector:
        """(3,) centre of a body, from the frame of its link and the place of its shape in it."""
        index = self._link_index[link]
        state = self._world.getLinkState(self._moving, index, computeForwardKinematics=True)
        ((_, _, _, _, _, centre, _),) = self._world.getCollisionShapeData(self._moving, index)
        turn = np.reshape(self._world.getMatrixFromQuaternion(state[5]), (3, 3))
        return np.asarray(np.asarray(state[4]) + turn @ centre)

    def _pose(self, angles: Vector, shift: Vector) -> None:
        self._place(self._moving, shift)
        self._world.resetJointStatesMultiDof(self._moving, self._joints, [[float(angle)] for angle in angles])

    def _place(self, body: int, shift: Vector) -> None:
        self._world.resetBasePositionAndOrientation(body, (self._origin + shift).tolist(), self._turn.tolist())


def _moved_links(path: Path) -> dict[str, str]:
    """Joint -> the link that it moves."""
    found = {}
    for joint in ElementTree.parse(path).getroot().findall("joint"):
        child = joint.find("child")
        if child is not None:
            found[joint.get("name", "")] = child.get("link", "")
    return found
