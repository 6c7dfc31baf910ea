"""Closed-form kinematics of a leg whose abduction axis is perpendicular to its parallel hip and knee axes.

At zero angles the leg is described in the orthonormal basis (u, v, w): u along the HAA axis, v along the HFE axis,
w = u x v. Abduction turns v towards w about u. Flexion turns w towards u about v, so that inside the leg plane the leg
is a two-link chain T (thigh), S (shank), at the constant distance d from the HAA axis along v.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.compiled import compiled, inlined
from footsel.errors import InputError

#: How far from perpendicular or parallel the axes of a URDF may be.
AXIS_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class LegKinematics:
    """One leg in the base frame.

    basis: (3, 3) rows u, v, w in the base frame.
    haa, hfe, kfe: (3,) a point of each joint's axis at zero angles, in [m].
    hip: (3,) the hip point L_i: where the HFE axis crosses the leg plane at zero abduction, in [m].
    hfe_offset: (2,) HFE axis relative to the HAA axis along u and w, in [m].
    plane_offset: d, of the foot's centre along v from the HAA axis, in [m].
    thigh, shank: (2,) links T and S along u and w at zero angles, in [m].
    knee_sign: +1 if the KFE axis points along v, -1 if against it.
    knee_branch: sign of the knee's bend from the stretched leg in the nominal stance.
    below: sign of w below the hip.
    limits: (3, 2) HAA HFE KFE, in [rad].
    """

    basis: NDArray[np.float64]
    haa: NDArray[np.float64]
    hfe: NDArray[np.float64]
    kfe: NDArray[np.float64]
    hip: NDArray[np.float64]
    hfe_offset: NDArray[np.float64]
    plane_offset: float
    thigh: NDArray[np.float64]
    shank: NDArray[np.float64]
    knee_sign: float
    knee_branch: float
    below: float
    limits: NDArray[np.float64]

    @classmethod
    def from_axes(
        cls,
        points: ArrayLike,
        axes: ArrayLike,
        foot: ArrayLike,
        stance: ArrayLike,
        limits: ArrayLike,
    ) -> "LegKinematics":
        """From the zero configuration in the base frame.

        points, axes: (3, 3) a point and the unit axis of HAA, HFE, KFE. foot: (3,) foot centre, in [m].
        stance: (3,) nominal angles, which fix the knee's branch. limits: (3, 2), both in [rad].
        Raises InputError if the axes are not those of such a leg.
        """
        points, foot = np.asarray(points, dtype=np.float64), np.asarray(foot, dtype=np.float64)
        u, v, knee_axis = np.asarray(axes, dtype=np.float64)
        knee_sign = float(np.sign(v @ knee_axis))
        if abs(u @ v) > AXIS_TOLERANCE or np.abs(knee_axis - knee_sign * v).max() > AXIS_TOLERANCE:
            raise InputError("leg axes are not HAA perpendicular to HFE parallel to KFE", "another solver is needed")
        basis = np.stack([u, v, np.cross(u, v)])
        haa, hfe, knee = points
        hfe_in = basis @ (hfe - haa)
        foot_in = basis @ (foot - haa)
        thigh = (basis @ (knee - hfe))[[0, 2]]
        shank = (basis @ (foot - knee))[[0, 2]]
        stretched = np.arctan2(thigh[0] * shank[1] - thigh[1] * shank[0], thigh @ shank)
        bend = np.angle(np.exp(1j * (knee_sign * np.asarray(stance, dtype=np.float64)[2] - stretched)))
        below = float(np.sign((basis @ np.array([0.0, 0.0, -1.0]))[2]))
        return cls(
            basis=basis,
            haa=haa,
            hfe=hfe,
            kfe=knee,
            hip=haa + basis.T @ np.array([hfe_in[0], foot_in[1], hfe_in[2]]),
            hfe_offset=hfe_in[[0, 2]],
            plane_offset=float(foot_in[1]),
            thigh=thigh,
            shank=shank,
            knee_sign=knee_sign,
            knee_branch=float(np.sign(bend)),
            below=below,
            limits=np.asarray(limits, dtype=np.float64),
        )

    def packed(self) -> NDArray[np.float64]:
        """The flat parameters that `solve` and `link_frames` take, positions relative to the hip point."""
        return np.concatenate(
            [
                self.basis.ravel(),
                self.haa - self.hip,
                self.hfe_offset,
                [self.plane_offset],
                self.thigh,
                self.shank,
                [self.knee_sign, self.knee_branch, self.below],
                self.limits.ravel(),
                self.basis @ (self.haa - self.hip),
                self.basis @ (self.hfe - self.haa),
                self.basis @ (self.kfe - self.hfe),
            ]
        )

    def inverse(self, foot_centres: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Joint angles (n, 3) for foot centres (n, 3), and which of them are in range (n,).

        foot_centres: relative to the hip point in the base frame, in [m].
        Rows out of range hold the angles only as far as they exist (NaN beyond the leg's reach).
        """
        targets = np.ascontiguousarray(foot_centres, dtype=np.float64).reshape(-1, 3)
        angles = np.full(targets.shape, np.nan)
        reachable = np.zeros(len(targets), dtype=np.bool_)
        solve_many(self.packed(), targets, angles, reachable)
        return angles, reachable

    def forward(self, angles: ArrayLike) -> NDArray[np.float64]:
        """Foot centre (..., 3) relative to the hip point in the base frame for angles (..., 3), in [m]."""
        q = np.asarray(angles, dtype=np.float64)
        knee = q[..., 1] + self.knee_sign * q[..., 2]
        along = self.hfe_offset[0] + _turn_u(self.thigh, q[..., 1]) + _turn_u(self.shank, knee)
        down = self.hfe_offset[1] + _turn_w(self.thigh, q[..., 1]) + _turn_w(self.shank, knee)
        c, s = np.cos(q[..., 0]), np.sin(q[..., 0])
        local = np.stack([along, c * self.plane_offset - s * down, s * self.plane_offset + c * down], axis=-1)
        return np.asarray(local @ self.basis + self.haa - self.hip)


def _turn_u(link: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(link[0] * np.cos(angle) + link[1] * np.sin(angle))


def _turn_w(link: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(-link[0] * np.sin(angle) + link[1] * np.cos(angle))


@inlined
def _wrapped(angle: float) -> float:
    """The angle in (-pi, pi]."""
    return float(angle - 2 * np.pi * np.ceil(angle / (2 * np.pi) - 0.5))


@compiled
def solve(
    leg: NDArray[np.float64], x: float, y: float, z: float
) -> tuple[bool, float, float, float]:  # pragma: no cover - compiled
    """Whether a foot centre relative to the hip point is in kinematic range, and its joint angles.

    The branch is the nominal stance's: the foot below the hip in the leg plane, the knee bent to its nominal side.
    """
    x, y, z = x - leg[9], y - leg[10], z - leg[11]
    along = leg[0] * x + leg[1] * y + leg[2] * z
    side = leg[3] * x + leg[4] * y + leg[5] * z
    up = leg[6] * x + leg[7] * y + leg[8] * z
    plane_offset = leg[14]
    square = side * side + up * up - plane_offset * plane_offset
    if square < 0.0:
        return False, np.nan, np.nan, np.nan
    down = leg[21] * np.sqrt(square)
    haa = _wrapped(np.arctan2(up, side) - np.arctan2(down, plane_offset))

    pu, pw = along - leg[12], down - leg[13]
    tu, tw, su, sw = leg[15], leg[16], leg[17], leg[18]
    dot, cross = tu * su + tw * sw, tu * sw - tw * su
    bend = (pu * pu + pw * pw - tu * tu - tw * tw - su * su - sw * sw) / (2 * np.sqrt(dot * dot + cross * cross))
    if bend < -1.0 or bend > 1.0:
        return False, haa, np.nan, np.nan
    knee = np.arctan2(cross, dot) + leg[20] * np.arccos(bend)
    ck, sk = np.cos(knee), np.sin(knee)
    au, aw = tu + su * ck + sw * sk, tw - su * sk + sw * ck
    hfe = np.arctan2(pu * aw - pw * au, pu * au + pw * aw)
    kfe = _wrapped(leg[19] * knee)
    in_range = leg[22] <= haa <= leg[23] and leg[24] <= hfe <= leg[25] and leg[26] <= kfe <= leg[27]
    return in_range, haa, hfe, kfe


@compiled
def solve_many(
    leg: NDArray[np.float64],
    targets: NDArray[np.float64],
    angles: NDArray[np.float64],
    reachable: NDArray[np.bool_],
) -> None:  # pragma: no cover - compiled
    """`solve` for every row of targets (n, 3), into angles (n, 3) and reachable (n,)."""
    for row in range(len(targets)):
        reachable[row], angles[row, 0], angles[row, 1], angles[row, 2] = solve(
            leg, targets[row, 0], targets[row, 1], targets[row, 2]
        )


@compiled
def link_frames(
    leg: NDArray[np.float64],
    axes: NDArray[np.float64],
    haa: float,
    hfe: float,
    kfe: float,
    rotations: NDArray[np.float64],
    origins: NDArray[np.float64],
) -> None:  # pragma: no cover - compiled
    """Where thigh and shank are, in the frame in which the leg's u, v, w at zero angles are the rows of axes (3, 3).

    rotations: (2, 3, 3) out, from the leg's u, v, w at zero angles to that frame: column by column, where they went.
    origins: (2, 3) out, HFE and KFE points relative to the hip point, in [m].
    """
    c, s = np.cos(haa), np.sin(haa)
    c_thigh, s_thigh = np.cos(hfe), np.sin(hfe)
    turn = hfe + leg[19] * kfe
    c_shank, s_shank = np.cos(turn), np.sin(turn)
    for i in range(3):
        u = axes[0, i]
        v, w = c * axes[1, i] + s * axes[2, i], c * axes[2, i] - s * axes[1, i]
        u_thigh, w_thigh = c_thigh * u - s_thigh * w, c_thigh * w + s_thigh * u
        rotations[0, i, 0], rotations[0, i, 1], rotations[0, i, 2] = u_thigh, v, w_thigh
        rotations[1, i, 0], rotations[1, i, 1], rotations[1, i, 2] = (
            c_shank * u - s_shank * w,
            v,
            c_shank * w + s_shank * u,
        )
        haa_point = leg[28] * u + leg[29] * axes[1, i] + leg[30] * axes[2, i]
        origins[0, i] = haa_point + leg[31] * u + leg[32] * v + leg[33] * w
        origins[1, i] = origins[0, i] + leg[34] * u_thigh + leg[35] * v + leg[36] * w_thigh
