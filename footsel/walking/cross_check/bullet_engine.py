"""PyBullet with the URDF's primitives and a triangle mesh: its own parser, forward kinematics and contacts."""

from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from footsel.errors import MissingExtraError
from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.terrain import LocalMap
from footsel.walking.cross_check.engine import NO_SHIFT, Engine, Vector
from footsel.walking.cross_check.split_urdf import TRIMMED, split_urdf
from footsel.walking.cross_check.terrain_mesh import TerrainMesh

try:
    import pybullet
except ImportError:
    raise MissingExtraError("the check with PyBullet", "sim", "pybullet") from None


class BulletEngine(Engine):
    """Two copies of the robot: the leg of one is moved, base and other legs of the other stand at the nominal stance.

    Contacts are those of getClosestPoints at distance 0.
    """

    def __init__(self, robot: Robot, leg: str) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
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
                pybullet.loadURDF(
                    str(path),
                    useFixedBase=True,
                    flags=pybullet.URDF_USE_IMPLICIT_CYLINDER,
                    physicsClientId=self._client,
                )
                for _ in range(2)
            )
        infos = [
            pybullet.getJointInfo(self._moving, index, physicsClientId=self._client)
            for index in range(pybullet.getNumJoints(self._moving, physicsClientId=self._client))
        ]
        joint_index = {info[1].decode(): info[0] for info in infos}
        self._link_index = {info[12].decode(): info[0] for info in infos}
        self._link_name = {index: name for name, index in self._link_index.items()}
        self._joints = [joint_index[name] for name in joints]
        for each in LEGS:
            for name, angle in zip(robot.description.joints[each], robot.description.stance[each], strict=True):
                for body in (self._moving, self._standing):
                    pybullet.resetJointState(body, joint_index[name], angle, physicsClientId=self._client)
        self._allowed = {(bodies.swing[i].name, bodies.obstacles[j].name) for i, j in bodies.pairs}
        self._swing = [body.name for body in bodies.swing]
        names = {body.name for body in cut}
        self._trimmed = {body.name: body.name + TRIMMED * (body.name in names) for body in bodies.trimmed}
        self._terrain: int | None = None

    def stand(self, local_map: LocalMap, tilt: Vector) -> None:
        """Put the base over a terrain."""
        if self._terrain is not None:
            pybullet.removeBody(self._terrain, physicsClientId=self._client)
        self._mesh = TerrainMesh.of(local_map)
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_MESH,
            vertices=self._mesh.vertices.tolist(),
            indices=self._mesh.triangles.ravel().tolist(),
            flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
            physicsClientId=self._client,
        )
        self._terrain = pybullet.createMultiBody(0, shape, physicsClientId=self._client)
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
            pybullet.disconnect(self._client)

    def _near(self, link: str, other: int) -> list[Any]:
        points = pybullet.getClosestPoints(
            self._moving, other, 0.0, linkIndexA=self._link_index[link], physicsClientId=self._client
        )
        return [point for point in points if point[8] <= 0]

    def _centre(self, link: str) -> Vector:
        """(3,) centre of a body, from the frame of its link and the place of its shape in it."""
        index = self._link_index[link]
        state = pybullet.getLinkState(self._moving, index, computeForwardKinematics=True, physicsClientId=self._client)
        ((_, _, _, _, _, centre, _),) = pybullet.getCollisionShapeData(
            self._moving, index, physicsClientId=self._client
        )
        turn = np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))
        return np.asarray(np.asarray(state[4]) + turn @ centre)

    def _pose(self, angles: Vector, shift: Vector) -> None:
        self._place(self._moving, shift)
        pybullet.resetJointStatesMultiDof(
            self._moving, self._joints, [[float(angle)] for angle in angles], physicsClientId=self._client
        )

    def _place(self, body: int, shift: Vector) -> None:
        pybullet.resetBasePositionAndOrientation(
            body, (self._origin + shift).tolist(), self._turn.tolist(), physicsClientId=self._client
        )


def _moved_links(path: Path) -> dict[str, str]:
    """Joint -> the link that it moves."""
    found = {}
    for joint in ElementTree.parse(path).getroot().findall("joint"):
        child = joint.find("child")
        if child is not None:
            found[joint.get("name", "")] = child.get("link", "")
    return found
