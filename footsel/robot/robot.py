"""A robot, ready for the oracle: kinematics and collision bodies per leg, read from its URDF once per process."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from footsel.errors import InputError, MissingExtraError
from footsel.footholds.layout import LegLayout
from footsel.legs import LEGS, is_right, mirror_of
from footsel.robot.description import RobotDescription, read_description, share_folder

try:
    import pinocchio as pin

    from footsel.robot.collision_geometry import LegBodies, leg_bodies, stance_configuration
    from footsel.robot.leg_kinematics import LegKinematics
except ImportError as error:
    raise MissingExtraError("reading a robot model", "oracle", error.name or "pin") from None


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot model.

    model, geometry: Pinocchio's, on a fixed base. foot_frames: leg -> frame at the foot sphere's centre.
    kinematics, bodies: per leg. layout: hip points and nominal feet.
    """

    description: RobotDescription
    model: Any
    geometry: Any
    foot_frames: Mapping[str, int]
    kinematics: Mapping[str, LegKinematics]
    bodies: Mapping[str, LegBodies]
    layout: LegLayout

    @property
    def name(self) -> str:
        """Name of the description."""
        return self.description.name

    def margin_max(self, leg: str) -> float:
        """The largest kinematic margin of a leg, in [m]."""
        margins = self.description.margin_max
        return margins[leg] if leg in margins else margins[mirror_of(leg)]

    def table_leg(self, leg: str) -> str:
        """The leg whose tables serve `leg`: the left one of the pair if the robot is symmetric."""
        return mirror_of(leg) if self.description.symmetric and is_right(leg) else leg


@cache
def load_robot(name: str = "anymal_b", limits: str | None = None) -> Robot:
    """Read a robot by its name, with one of its named limit sets (default: the description's)."""
    description = read_description(name, limits)
    path = str(description.urdf_path)
    share = str(share_folder(description.urdf))
    model = pin.buildModelFromUrdf(path)
    geometry = pin.buildGeomFromUrdf(model, path, pin.GeometryType.COLLISION, package_dirs=[share])
    zero = pin.neutral(model)
    data = model.createData()
    # The angular part of a revolute joint's Jacobian column is its axis, here in the base frame.
    jacobian = pin.computeJointJacobians(model, data, zero)

    kinematics, foot_frames, foot_in_knee = {}, {}, {}
    for leg in LEGS:
        sphere = geometry.geometryObjects[_geometry_index(geometry, description.foot_geometry[leg])]
        radius = getattr(sphere.geometry, "radius", None)
        if radius is None or abs(radius - description.foot_radius) > 1e-9:
            raise InputError(
                f"{name}: foot geometry {sphere.name} has radius {radius}",
                f"the description says {description.foot_radius} m",
            )
        joints = [model.getJointId(joint) for joint in description.joints[leg]]
        foot_in_knee[leg] = sphere.placement.translation.copy()
        frame = pin.Frame(f"{leg}_foot_centre", sphere.parentJoint, sphere.placement, pin.FrameType.OP_FRAME)
        foot_frames[leg] = model.addFrame(frame)
        kinematics[leg] = LegKinematics.from_axes(
            points=[data.oMi[joint].translation for joint in joints],
            axes=[jacobian[3:, model.joints[joint].idx_v] for joint in joints],
            foot=data.oMi[sphere.parentJoint].act(sphere.placement.translation),
            stance=description.stance[leg],
            limits=description.limits[leg],
        )

    down = np.array([0.0, 0.0, description.foot_radius])
    layout = LegLayout(
        hips={leg: kinematics[leg].hip for leg in LEGS},
        nominal_feet={
            leg: kinematics[leg].hip + kinematics[leg].forward(description.stance[leg]) - down for leg in LEGS
        },
        resolution=description.resolution,
        height_range=description.height_range,
        foot_radius=description.foot_radius,
    )
    bodies = leg_bodies(description, model, geometry, foot_in_knee)
    return Robot(description, model, geometry, foot_frames, kinematics, bodies, layout)


def _geometry_index(geometry: Any, name: str) -> int:
    if not geometry.existGeometryName(name):
        names = [item.name for item in geometry.geometryObjects]
        raise InputError(f"no collision geometry {name!r} in the URDF", f"it has: {', '.join(names)}")
    return int(geometry.getGeometryId(name))


__all__ = ["Robot", "load_robot", "stance_configuration"]
