"""The bodies of a swinging leg, placed by its joint angles, with cover spheres that spare most questions to coal."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.robot.collision_geometry import Body
from footsel.robot.leg_kinematics import link_frames
from footsel.robot.robot import Robot

#: Distance between the centres of cover spheres along a body, and between points of its skin. [m]
SPHERE_SPACING = 0.02
SKIN_SPACING = 0.02

#: Points of the skin lie on the surface of the shape made smaller by this factor, so they are inside it for certain.
SKIN_SCALE = 0.999


@dataclass(frozen=True, eq=False)
class SwingBodies:
    """m bodies of one leg. Axes are the base's; positions are relative to the link's joint (HFE for the thigh, KFE for
    the shank) with the leg at zero angles.

    leg: parameters of the kinematics (LegKinematics.packed).
    link: (m,) 0 thigh, 1 shank. rotation: (m, 3, 3) and centre: (m, 3) placement of each shape, in [m].
    spheres: (s, 5) body, centre, radius: together they cover the bodies.
    skin: (c, 4) body, point: points inside the bodies, just below their surface.
    """

    bodies: tuple[Body, ...]
    leg: NDArray[np.float64]
    link: NDArray[np.int64]
    rotation: NDArray[np.float64]
    centre: NDArray[np.float64]
    spheres: NDArray[np.float64]
    skin: NDArray[np.float64]

    @classmethod
    def of(cls, robot: Robot, leg: str, bodies: Sequence[Body]) -> "SwingBodies":
        """Place `bodies` of a leg for its kinematics."""
        data = robot.model.createData()
        pin.forwardKinematics(robot.model, data, pin.neutral(robot.model))
        rotations, centres, spheres, skin = [], [], [], []
        for index, body in enumerate(bodies):
            joint = data.oMi[robot.model.getJointId(robot.description.joints[leg][body.joint - 1])]
            axis_point = (robot.kinematics[leg].hfe, robot.kinematics[leg].kfe)[body.joint - 2]
            rotation = joint.rotation @ body.rotation
            centre = joint.act(body.translation) - axis_point
            rotations.append(rotation)
            centres.append(centre)
            points, radius = cover_spheres(body.shape)
            spheres += [(index, *(centre + rotation @ point), radius) for point in points]
            skin += [(index, *(centre + rotation @ point)) for point in skin_points(body.shape)]
        return cls(
            bodies=tuple(bodies),
            leg=robot.kinematics[leg].packed(),
            link=np.array([body.joint - 2 for body in bodies]),
            rotation=np.array(rotations),
            centre=np.array(centres),
            spheres=np.array(spheres),
            skin=np.array(skin).reshape(-1, 4),
        )

    def placements(self, angles: NDArray[np.float64]) -> list[Any]:
        """coal transforms of all bodies in base axes, relative to the hip point, for angles (3,)."""
        rotations, origins = np.empty((2, 3, 3)), np.empty((2, 3))
        link_frames(self.leg, angles[0], angles[1], angles[2], rotations, origins)
        turns = rotations[self.link]
        translation = origins[self.link] + np.einsum("mij,mj->mi", turns, self.centre)
        return [coal.Transform3s(r, t) for r, t in zip(turns @ self.rotation, translation, strict=True)]


def cover_spheres(shape: Any) -> tuple[NDArray[np.float64], float]:
    """Centres (k, 3) inside the shape, in its frame, and the radius at which spheres there cover it, in [m].

    Centres lie on the longest axis of the shape's bounding box; a cylinder or capsule along that axis is covered
    more tightly than its box.
    """
    shape.computeLocalAABB()
    low, high = np.array(shape.aabb_local.min_), np.array(shape.aabb_local.max_)
    middle, half = (low + high) / 2, (high - low) / 2
    if isinstance(shape, coal.Sphere):
        return middle[None], float(shape.radius)
    axis = int(np.argmax(half))
    across = float(np.linalg.norm(np.delete(half, axis)))
    if isinstance(shape, coal.Cylinder | coal.Capsule) and axis == 2:
        across = float(shape.radius)
    count = max(int(np.ceil(2 * half[axis] / SPHERE_SPACING)), 1)
    piece = 2 * half[axis] / count
    centres = np.tile(middle, (count, 1))
    centres[:, axis] = low[axis] + (np.arange(count) + 0.5) * piece
    return centres, float(np.hypot(across, piece / 2))


def skin_points(shape: Any) -> NDArray[np.float64]:
    """Points (k, 3) inside the shape, just below its surface, in its frame, in [m]; none for shapes not listed."""
    if isinstance(shape, coal.Box):
        axes = [_spread(-half, half) for half in np.asarray(shape.halfSide)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        on_surface = (np.abs(points) >= np.asarray(shape.halfSide) - 1e-12).any(axis=1)
        return np.asarray(points[on_surface] * SKIN_SCALE)
    if isinstance(shape, coal.Cylinder | coal.Capsule):
        around = np.linspace(0, 2 * np.pi, 9)[:-1]
        rings = [
            np.column_stack([radius * np.cos(around), radius * np.sin(around), np.full(len(around), z)])
            for z in _spread(-shape.halfLength, shape.halfLength)
            for radius in ((shape.radius, shape.radius / 2) if abs(z) == shape.halfLength else (shape.radius,))
        ]
        return np.asarray(np.concatenate(rings) * SKIN_SCALE)
    return np.empty((0, 3))


def _spread(low: float, high: float) -> NDArray[np.float64]:
    """Values from one end to the other, at most SKIN_SPACING apart."""
    return np.linspace(low, high, int(np.ceil((high - low) / SKIN_SPACING)) + 1)
