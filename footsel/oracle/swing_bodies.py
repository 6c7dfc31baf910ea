"""The bodies of a swinging leg, placed by its joint angles."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.oracle.convex import placed, shape_row
from footsel.robot.collision_geometry import Body
from footsel.robot.leg_kinematics import link_frames
from footsel.robot.robot import Robot


@dataclass(frozen=True, eq=False)
class SwingBodies:
    """m bodies of one leg, along the leg's own axes u, v, w (LegKinematics) and relative to the link's joint (HFE for
    the thigh, KFE for the shank), with the leg at zero angles.

    leg: parameters of the kinematics (LegKinematics.packed). axes: (3, 3) rows u, v, w in the base frame.
    link: (m,) 0 thigh, 1 shank. rotation: (m, 3, 3) and centre: (m, 3) placement of each shape, in [m].
    rows: (m, 16) the same for compiled code, as in `convex`. exact: (m,) whether a row is the shape itself.
    """

    bodies: tuple[Body, ...]
    leg: NDArray[np.float64]
    axes: NDArray[np.float64]
    link: NDArray[np.int64]
    rotation: NDArray[np.float64]
    centre: NDArray[np.float64]
    rows: NDArray[np.float64]
    exact: NDArray[np.bool_]

    @classmethod
    def of(cls, robot: Robot, leg: str, bodies: Sequence[Body]) -> "SwingBodies":
        """Place `bodies` of a leg for its kinematics."""
        kinematics, data = robot.kinematics[leg], robot.model.createData()
        pin.forwardKinematics(robot.model, data, pin.neutral(robot.model))
        rotations, centres, rows, exact = [], [], [], []
        for body in bodies:
            joint = data.oMi[robot.model.getJointId(robot.description.joints[leg][body.joint - 1])]
            axis_point = (kinematics.hfe, kinematics.kfe)[body.joint - 2]
            rotations.append(kinematics.basis @ joint.rotation @ body.rotation)
            centres.append(kinematics.basis @ (joint.act(body.translation) - axis_point))
            row, is_exact = shape_row(body.shape)
            rows.append(placed(row, rotations[-1], centres[-1]))
            exact.append(is_exact)
        return cls(
            bodies=tuple(bodies),
            leg=kinematics.packed(),
            axes=kinematics.basis,
            link=np.array([body.joint - 2 for body in bodies]),
            rotation=np.array(rotations),
            centre=np.array(centres),
            rows=np.array(rows),
            exact=np.array(exact),
        )

    def placements(self, angles: NDArray[np.float64]) -> list[Any]:
        """coal transforms of all bodies in base axes, relative to the hip point, for angles (3,)."""
        rotations, origins = np.empty((2, 3, 3)), np.empty((2, 3))
        link_frames(self.leg, self.axes, angles[0], angles[1], angles[2], rotations, origins)
        turns = rotations[self.link]
        translation = origins[self.link] + np.einsum("mij,mj->mi", turns, self.centre)
        return [coal.Transform3s(r, t) for r, t in zip(turns @ self.rotation, translation, strict=True)]
