"""The URDF's collision geometry, sorted into what swings with a leg and what stands still around it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.errors import InputError
from footsel.legs import LEGS
from footsel.robot.description import RobotDescription


@dataclass(frozen=True, eq=False)
class Body:
    """One collision geometry, rigid in the frame of a joint.

    name: as in the URDF. shape: a coal geometry.
    joint: 0 for the base, 1 HAA, 2 HFE, 3 KFE of its leg.
    rotation, translation: placement in the frame of that joint, in [m].
    """

    name: str
    shape: Any
    joint: int
    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LegBodies:
    """What can collide when one leg swings.

    swing: the leg's thigh, shank and foot.
    trimmed: the same without what lies near the foot's centre, for the check against terrain.
    obstacles: base and other legs at the nominal stance, placed in the base frame.
    pairs: (swing index, obstacle index) to be checked: all but those that touch at the nominal stance.
    """

    swing: tuple[Body, ...]
    trimmed: tuple[Body, ...]
    obstacles: tuple[Body, ...]
    pairs: tuple[tuple[int, int], ...]


def leg_bodies(
    description: RobotDescription, model: pin.Model, geometry: pin.GeometryModel, foot_in_knee: Mapping[str, Any]
) -> dict[str, LegBodies]:
    """Bodies of every leg.

    model: the robot on a fixed base. foot_in_knee: leg -> (3,) foot centre in the frame of the KFE joint, in [m].
    """
    stance = stance_configuration(description, model)
    data, geometry_data = model.createData(), geometry.createData()
    pin.updateGeometryPlacements(model, data, geometry, geometry_data, stance)
    joint_of = {
        model.getJointId(name): (leg, index + 1) for leg in LEGS for index, name in enumerate(description.joints[leg])
    }
    moving: dict[str, list[Body]] = {leg: [] for leg in LEGS}
    standing: dict[str, list[Body]] = {leg: [] for leg in (*LEGS, "base")}
    nominal: dict[str, Any] = {}
    for index, item in enumerate(geometry.geometryObjects):
        leg, joint = joint_of.get(item.parentJoint, ("base", 0))
        in_base = geometry_data.oMg[index]
        nominal[item.name] = in_base
        standing[leg].append(Body(item.name, item.geometry, 0, in_base.rotation.copy(), in_base.translation.copy()))
        if joint >= 2:
            placement = item.placement
            moving[leg].append(
                Body(item.name, item.geometry, joint, placement.rotation.copy(), placement.translation.copy())
            )

    bodies = {}
    for leg in LEGS:
        swing = tuple(moving[leg])
        obstacles = tuple(body for part in standing if part != leg for body in standing[part])
        pairs = tuple(
            (i, j)
            for i, body in enumerate(swing)
            for j, obstacle in enumerate(obstacles)
            if not _touch(body.shape, nominal[body.name], obstacle.shape, nominal[obstacle.name])
        )
        trimmed = tuple(
            part for body in swing if (part := _trim(body, foot_in_knee[leg], description.foot_trim)) is not None
        )
        bodies[leg] = LegBodies(swing, trimmed, obstacles, pairs)
    return bodies


def stance_configuration(description: RobotDescription, model: pin.Model) -> NDArray[np.float64]:
    """(nq,) the nominal stance of all legs. Joints are addressed by name: their order differs between libraries."""
    configuration = pin.neutral(model)
    for leg in LEGS:
        for name, angle in zip(description.joints[leg], description.stance[leg], strict=True):
            configuration[model.joints[model.getJointId(name)].idx_q] = angle
    return np.asarray(configuration)


def _touch(shape_a: Any, placement_a: Any, shape_b: Any, placement_b: Any) -> bool:
    request, result = coal.CollisionRequest(), coal.CollisionResult()
    transform_a = coal.Transform3s(placement_a.rotation, placement_a.translation)
    transform_b = coal.Transform3s(placement_b.rotation, placement_b.translation)
    return bool(coal.collide(shape_a, transform_a, shape_b, transform_b, request, result))


def _trim(body: Body, foot: NDArray[np.float64], radius: float) -> Body | None:
    """The body without its part near the foot's centre: None if nothing is left.

    A sphere is dropped if its centre is within the radius; a cylinder or capsule is cut across its axis, so that what
    is left stays `radius` away from the foot along the axis. Other shapes must be clear of the foot as they are.
    """
    if body.joint != 3:
        return body
    centre = body.rotation.T @ (foot - body.translation)
    shape = body.shape
    if isinstance(shape, coal.Sphere):
        return None if np.linalg.norm(centre) < radius else body
    if isinstance(shape, coal.Cylinder | coal.Capsule):
        half, reach = shape.halfLength, shape.radius
        if np.hypot(centre[0], centre[1]) - reach >= radius or abs(centre[2]) - half >= radius:
            return body
        # The longer of the two pieces on either side of the foot is the leg; the other ends inside the foot.
        lower, upper = (-half, centre[2] - radius), (centre[2] + radius, half)
        low, high = max(lower, upper, key=lambda piece: piece[1] - piece[0])
        if high <= low:
            return None
        cut = type(shape)(reach, high - low)
        return Body(
            body.name,
            cut,
            body.joint,
            body.rotation,
            body.translation + body.rotation @ np.array([0.0, 0.0, (low + high) / 2]),
        )
    if _distance_to_point(shape, centre) < radius:
        raise InputError(
            f"collision geometry {body.name} ({type(shape).__name__}) reaches within {radius} m of the foot's centre",
            "only spheres, cylinders and capsules can be trimmed: describe the lower shank by one of these",
        )
    return body


def _distance_to_point(shape: Any, point: NDArray[np.float64]) -> float:
    """Distance of a point to a shape's surface, in the shape's frame, in [m]."""
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    here, there = coal.Transform3s.Identity(), coal.Transform3s(np.eye(3), point)
    return float(coal.distance(shape, here, coal.Sphere(1e-9), there, request, result))
