"""The robot's full meshes, those that its URDF shows, sorted as the oracle sorts the collision primitives."""

from functools import cache
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.errors import InputError
from footsel.legs import check_leg
from footsel.robot.collision_geometry import Body, LegBodies, stance_configuration
from footsel.robot.description import share_folder
from footsel.robot.robot import Robot
from footsel.walking.cross_check.terrain_mesh import triangle_model


@cache
def leg_meshes(robot: Robot, leg: str) -> LegBodies:
    """Meshes of the swing leg's thigh, shank and foot, and of what stands around it.

    Pairs that touch at the nominal stance are left out, as for the primitives. The lower shank is cut off where the
    primitives are cut: across its axis at the trim radius above the foot's centre.
    """
    description, model = robot.description, robot.model
    geometry = pin.buildGeomFromUrdf(
        model,
        str(description.urdf_path),
        pin.GeometryType.VISUAL,
        package_dirs=[str(share_folder(description.urdf))],
    )
    data, geometry_data = model.createData(), geometry.createData()
    pin.updateGeometryPlacements(model, data, geometry, geometry_data, stance_configuration(description, model))
    joints = [model.getJointId(name) for name in description.joints[check_leg(leg)]]
    swing, obstacles = [], []
    for item, placed in zip(geometry.geometryObjects, geometry_data.oMg, strict=True):
        shape = item.geometry
        shape.computeLocalAABB()
        name = item.name.rpartition("_")[0] + " mesh"
        if item.parentJoint not in joints:
            obstacles.append(Body(name, shape, 0, placed.rotation.copy(), placed.translation.copy()))
        elif item.parentJoint != joints[0]:
            at = item.placement
            joint = joints.index(item.parentJoint) + 1
            swing.append(Body(name, shape, joint, at.rotation.copy(), at.translation.copy()))
    if not all(isinstance(body.shape, coal.BVHModelOBBRSS) for body in swing):
        raise InputError(f"{robot.name} has no meshes of its legs", "its primitives are all there is to check")

    pairs = tuple(
        (i, j)
        for i, body in enumerate(swing)
        for j, other in enumerate(obstacles)
        if not _touch(body, data.oMi[joints[body.joint - 1]], other)
    )
    point, axis = _cut(robot, leg)
    trimmed = tuple(body if body.joint != 3 else _clipped(body, point, axis) for body in swing)
    return LegBodies(tuple(swing), trimmed, tuple(obstacles), pairs)


def _cut(robot: Robot, leg: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(3,) a point of the plane that cuts the shank and (3,) its normal towards the knee, in the KFE joint's frame."""
    bodies = robot.bodies[leg]
    whole = {body.name: body for body in bodies.swing}
    (shank,) = (body for body in bodies.trimmed if body.shape is not whole[body.name].shape)
    away = shank.translation - whole[shank.name].translation
    axis = away / np.linalg.norm(away)
    return shank.translation - axis * shank.shape.halfLength, axis


def _clipped(body: Body, point: NDArray[np.float64], axis: NDArray[np.float64]) -> Body:
    """The mesh on that side of the plane to which `axis` points; triangles across the plane are cut."""
    normal, offset = body.rotation.T @ axis, body.rotation.T @ (point - body.translation)
    vertices = np.array(body.shape.vertices())
    corners = vertices[_indices(body.shape)]
    depth = (corners - offset) @ normal
    kept = [triangle for triangle, d in zip(corners, depth, strict=True) if (d >= 0).all()]
    for triangle, d in zip(corners, depth, strict=True):
        if (d >= 0).any() and (d < 0).any():
            polygon = _above(triangle, d)
            kept += [np.array([polygon[0], polygon[k], polygon[k + 1]]) for k in range(1, len(polygon) - 1)]
    model = triangle_model(np.concatenate(kept), np.arange(3 * len(kept)).reshape(-1, 3))
    return Body(body.name, model, body.joint, body.rotation, body.translation)


def _above(triangle: NDArray[np.float64], depth: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Corners of the part of a triangle (3, 3) where depth (3,) is not negative."""
    polygon = []
    for k in range(3):
        here, there = depth[k], depth[(k + 1) % 3]
        if here >= 0:
            polygon.append(triangle[k])
        if (here >= 0) != (there >= 0):
            polygon.append(triangle[k] + here / (here - there) * (triangle[(k + 1) % 3] - triangle[k]))
    return polygon


def _indices(model: Any) -> NDArray[np.intp]:
    """(t, 3) indices of a model's triangles."""
    triangles = (model.tri_indices(index) for index in range(model.num_tris))
    return np.array([[triangle[0], triangle[1], triangle[2]] for triangle in triangles])


def _touch(body: Body, joint: Any, other: Body) -> bool:
    placed = joint * pin.SE3(body.rotation, body.translation)
    return bool(
        coal.collide(
            body.shape,
            coal.Transform3s(placed.rotation, placed.translation),
            other.shape,
            coal.Transform3s(other.rotation, other.translation),
            coal.CollisionRequest(),
            coal.CollisionResult(),
        )
    )
