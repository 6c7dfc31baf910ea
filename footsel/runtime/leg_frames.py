"""Where the legs are at some base poses: their hip points, headings and nominal feet, many at once."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.layout import LegLayout
from footsel.legs import is_right


@dataclass(frozen=True, eq=False)
class LegFrames:
    """m legs, each at a base pose. Axes of a leg's map are those of H; of right legs mirrored, with y to the right.

    legs: (m,) names. poses: (m, 6) x, y, z, roll, pitch, yaw of the base in the world frame, in [m] and [rad].
    hips: (m, 3) L_i in the world frame, in [m]. heading: (m, 2) cosine and sine of the yaw.
    nominal: (m, 3) N_i in the world frame, z NaN where it is for the terrain to say, in [m].
    ground: (m,) height of the ground of the standing base, in [m].
    """

    legs: tuple[str, ...]
    poses: NDArray[np.float64]
    hips: NDArray[np.float64]
    heading: NDArray[np.float64]
    nominal: NDArray[np.float64]
    ground: NDArray[np.float64]

    @cached_property
    def side(self) -> NDArray[np.float64]:
        """(m,) -1 for right legs, which see the world mirrored along y; 1 for left legs."""
        return np.array([-1.0 if is_right(leg) else 1.0 for leg in self.legs])

    def in_map(self, xy: NDArray[np.float64]) -> NDArray[np.float64]:
        """(m, 2) one world point of each leg (m, 2), or one of all (2,), in the axes of the leg's map, in [m]."""
        x, y = (xy - self.hips[:, :2]).T
        c, s = self.heading.T
        return np.stack([c * x + s * y, self.side * (c * y - s * x)], axis=-1)

    def nominal_on(self, terrain: NDArray[np.float32]) -> NDArray[np.float64]:
        """(m, 3) N_i in the world frame, at the terrain's heights (m,); where those are unknown on `ground`, in [m]."""
        found = self.nominal.copy()
        found[:, 2] = np.where(np.isnan(terrain), self.ground, terrain)
        return np.where(np.isnan(self.nominal), found, self.nominal)

    def to_world(self, leg: Any, x: Any, y: Any) -> tuple[Any, Any]:
        """World x and y of points in the axes of the maps of `leg`, one or several, in [m]."""
        c, s = self.heading[leg].T
        left = y * self.side[leg]
        return self.hips[leg, 0] + c * x - s * left, self.hips[leg, 1] + s * x + c * left


class Body:
    """The robot's layout as arrays."""

    def __init__(self, layout: LegLayout) -> None:
        self._hips = {leg: np.asarray(hip) for leg, hip in layout.hips.items()}
        self._feet = {leg: np.asarray(foot) for leg, foot in layout.nominal_feet.items()}

    def place(
        self, poses: NDArray[np.float64], legs: Sequence[str], nominal: Mapping[str, NDArray[np.float64]]
    ) -> LegFrames:
        """Frames of all legs at all poses, leg after leg, each leg's in the order of the poses.

        poses: (n, 6). nominal: leg -> (2,), (3,), (n, 2) or (n, 3) N_i in the world frame, in [m]; the nominal stance
        for legs not named.
        """
        count = len(poses)
        hips, feet = (np.array([points[leg] for leg in legs]) for points in (self._hips, self._feet))  # (l, 3)
        tilted, turned = (np.array(each) for each in zip(*map(_rotations, poses.tolist()), strict=True))
        placed = np.empty((count, len(legs), 6))  # L_i, then N_i
        np.matmul(hips, tilted, out=placed[..., :3])
        np.matmul(feet, turned, out=placed[..., 3:])
        placed[..., :3] += poses[:, None, :3]
        placed[..., 3:] += poses[:, None, :3]
        ground = placed[..., 5].T.flatten()
        placed[..., 5] = np.nan
        for number, leg in enumerate(legs):
            if leg in nominal:
                point = nominal[leg]
                placed[:, number, 3 : 3 + point.shape[-1]] = point
        flat = placed.swapaxes(0, 1).reshape(-1, 6)
        return LegFrames(
            legs=tuple(leg for leg in legs for _ in range(count)),
            poses=np.concatenate([poses] * len(legs)),
            hips=flat[:, :3],
            heading=np.concatenate([turned[:, 0, :2]] * len(legs)),
            nominal=flat[:, 3:],
            ground=ground,
        )


def _rotations(pose: Sequence[float]) -> tuple[list[list[float]], list[list[float]]]:
    """Transposed rotations from the base to the world, of the whole pose and of its yaw alone.

    In scalars: for a handful of poses many times as fast as arrays. footholds.pose has the same as matrices.
    """
    cr, cp, cy = map(math.cos, pose[3:])
    sr, sp, sy = map(math.sin, pose[3:])
    return (
        [
            [cy * cp, sy * cp, -sp],
            [cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr],
            [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr],
        ],
        [[cy, sy, 0.0], [-sy, cy, 0.0], [0.0, 0.0, 1.0]],
    )
