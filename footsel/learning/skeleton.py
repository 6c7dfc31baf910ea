"""A leg as a network's fixed layer needs it: closed-form kinematics in numbers, and balls in place of its bodies."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.learning.silhouette import surface_points
from footsel.oracle.convex import CENTRE, ROW
from footsel.oracle.swing_bodies import SwingBodies
from footsel.robot import Robot
from footsel.robot.medial_axis import medial_axis

#: Balls along a body are at most this far apart, in cells of the local map.
SPACING = 3.5
#: Balls are so many times as thick as the body, to make up for rims and corners. By trial on 200 local maps: of the
#: cells in range, the least clearance then tells 98.0 % as the oracle does; with balls as thick as the body 97.0 %.
THICKENED = 1.1
#: A body belongs to the hip if all of it is closer to the HFE axis than so many lengths of the thigh.
HIP = 0.4


@dataclass(frozen=True, eq=False)
class LegSkeleton:
    """Lengths of one leg and balls along what may touch the terrain.

    basis: (3, 3) rows u, v, w of footsel.robot.LegKinematics in the base frame. haa: (3,) point of the HAA axis from
    the hip point L_i, in the base frame, in [m]. hfe_offset: (2,) HFE axis from there along u and w, in [m].
    plane_offset: of the foot's centre along v, in [m]. thigh, shank: (2,) links along u and w at zero angles, in [m].
    knee_branch, below: signs, as in LegKinematics.
    link: (m,) 0 for a ball on the thigh, 1 on the shank. balls: (m, 3) centre along u, v, w at zero angles, from the
    HFE axis (thigh) or the KFE axis (shank), v from the HAA axis, in [m]. radius: (m,) in [m].
    hip: (b, 16) bodies of the thigh that keep close to the HFE axis, rows as in footsel.oracle.convex, placed like the
        balls on it; None of a skeleton from before there were any.
    rises: (radii, rings) how far the centre of a ball lies above what it touches, the cells of square rings around it,
    smallest radius first, in [m]; None for those of spheres.
    """

    basis: NDArray[np.float64]
    haa: NDArray[np.float64]
    hfe_offset: NDArray[np.float64]
    plane_offset: float
    thigh: NDArray[np.float64]
    shank: NDArray[np.float64]
    knee_branch: float
    below: float
    link: NDArray[np.int64]
    balls: NDArray[np.float64]
    radius: NDArray[np.float64]
    hip: NDArray[np.float64] | None = None
    rises: NDArray[np.float64] | None = None

    @property
    def length(self) -> float:
        """Of the stretched leg, in [m]."""
        return float(np.linalg.norm(self.thigh) + np.linalg.norm(self.shank))

    @classmethod
    def of(cls, robot: Robot, leg: str) -> "LegSkeleton":
        """The leg `leg` of a robot, with balls in the bodies that the oracle holds against the terrain."""
        kinematics = robot.kinematics[leg]
        bodies = SwingBodies.of(robot, leg, robot.bodies[leg].trimmed)
        to_hfe = kinematics.basis @ (kinematics.hfe - kinematics.haa)
        to_kfe = kinematics.basis @ (kinematics.kfe - kinematics.hfe)
        aside = np.array([to_hfe[1], to_hfe[1] + to_kfe[1]])  # Of the two joints' points along v.
        links, balls, radii, hip = [], [], [], []
        for row in bodies.rows[bodies.link == 0]:
            around = surface_points(row)
            if np.hypot(around[:, 0], around[:, 2]).max() < HIP * np.linalg.norm(kinematics.thigh):
                hip.append(row + np.eye(ROW)[CENTRE + 1] * aside[0])
        for body, link, rotation, centre in zip(
            bodies.bodies, bodies.link, bodies.rotation, bodies.centre, strict=True
        ):
            axis, half_length, widths = medial_axis(body.shape)
            radius = float(widths.mean())
            farthest = max(half_length - radius, 0.0)
            count = 1 + int(np.ceil(2 * farthest / (SPACING * robot.layout.resolution)))
            for along in np.linspace(-farthest, farthest, count):
                links.append(int(link))
                balls.append(centre + along * rotation[:, axis] + np.array([0.0, aside[link], 0.0]))
                radii.append(THICKENED * radius)
        return cls(
            basis=kinematics.basis,
            haa=kinematics.haa - kinematics.hip,
            hfe_offset=kinematics.hfe_offset,
            plane_offset=kinematics.plane_offset,
            thigh=kinematics.thigh,
            shank=kinematics.shank,
            knee_branch=kinematics.knee_branch,
            below=kinematics.below,
            link=np.array(links),
            balls=np.array(balls),
            radius=np.array(radii),
            hip=np.reshape(hip, (-1, ROW)),
        )

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values; `from_dict` is its inverse."""
        return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in vars(self).items()}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "LegSkeleton":
        """From the JSON values of `to_dict`."""
        arrays: dict[str, Any] = {
            key: np.array(value) if isinstance(value, list) else value for key, value in values.items()
        }
        return cls(**arrays)
