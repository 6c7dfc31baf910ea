"""The robot's own bodies at given joint angles, as the capsules that the map leaves out; and its feet."""

from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.legs import LEGS
from footsel.mapping import Capsule
from footsel.robot.robot import Robot

Array = NDArray[np.float64]


class OwnBodies:
    """Forward kinematics of the robot's collision bodies and feet."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._data, self._placements = robot.model.createData(), robot.geometry.createData()
        self._shapes = [_spine(item.geometry) for item in robot.geometry.geometryObjects]
        joints = [name for leg in LEGS for name in robot.description.joints[leg]]
        self._index = [robot.model.joints[robot.model.getJointId(name)].idx_q for name in joints]

    def capsules(self, base: Array, joints: Array) -> list[Capsule]:
        """In W. base: (4, 4) placement of the base in W. joints: (12,) by LEGS and HAA HFE KFE, in [rad]."""
        pin.updateGeometryPlacements(
            self._robot.model, self._data, self._robot.geometry, self._placements, self._configuration(joints)
        )
        bodies = []
        for (half, radius), in_base in zip(self._shapes, self._placements.oMg, strict=True):
            middle, along = in_base.translation, in_base.rotation @ half
            start, end = ((base[:3, :3] @ point) + base[:3, 3] for point in (middle - along, middle + along))
            bodies.append(Capsule(start, end, radius))
        return bodies

    def soles(self, base: Array, joints: Array) -> Array:
        """(4, 3) the lowest points of the feet by LEGS, in W, in [m]."""
        pin.framesForwardKinematics(self._robot.model, self._data, self._configuration(joints))
        frames = [self._data.oMf[self._robot.foot_frames[leg]].translation for leg in LEGS]
        centres = np.array(frames) @ base[:3, :3].T + base[:3, 3]
        return np.asarray(centres - [0, 0, self._robot.description.foot_radius])

    def _configuration(self, joints: Array) -> Array:
        configuration = pin.neutral(self._robot.model)
        configuration[self._index] = joints
        return np.asarray(configuration)


def _spine(shape: Any) -> tuple[Array, float]:
    """(3,) half of a line in the shape's frame, and how far around it the shape reaches, in [m]."""
    if isinstance(shape, coal.Sphere):
        return np.zeros(3), float(shape.radius)
    if isinstance(shape, coal.Cylinder | coal.Capsule):
        return np.array([0.0, 0.0, shape.halfLength]), float(shape.radius)
    # A box, or the box around anything else.
    shape.computeLocalAABB()
    half = np.asarray(shape.halfSide if isinstance(shape, coal.Box) else _reach(shape), dtype=np.float64)
    longest = int(np.argmax(half))
    return np.eye(3)[longest] * half, float(np.linalg.norm(np.delete(half, longest)))


def _reach(shape: Any) -> Array:
    """(3,) how far a shape reaches from the origin of its frame."""
    box = shape.aabb_local
    return np.asarray(np.maximum(np.abs(box.min_), np.abs(box.max_)))
