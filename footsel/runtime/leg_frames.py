"""Where the legs are at some base poses: their hip points, headings and nominal feet, many at once."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.layout import LegLayout
from footsel.legs import LEGS, is_right


@dataclass(frozen=True, eq=False)
class LegFrames:
    """m legs, each at a base pose. Axes of a leg's map are those of H; of right legs mirrored, with y to the right.

    legs: (m,) names. side: (m,) -1 for right legs, which see the world mirrored along y; 1 for left legs.
    hips: (m, 3) L_i in the world frame, in [m]. heading: (m, 2) cosine and sine of the base's yaw.
    roll, pitch: (m,) tilt of the base as the leg sees it, mirrored for right legs, in [rad].
    nominal: (m, 3) N_i in the world frame, z NaN where it is for the terrain to say, in [m].
    ground: (m,) height of the ground of the standing base, in [m].
    """

    legs: tuple[str, ...]
    side: NDArray[np.float64]
    hips: NDArray[np.float64]
    heading: NDArray[np.float64]
    roll: NDArray[np.float64]
    pitch: NDArray[np.float64]
    nominal: NDArray[np.float64]
    ground: NDArray[np.float64]

    def in_map(self, xy: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """x and y (m,) of one world point of each leg (m, 2), or of all (2,), in the axes of the leg's map, in [m]."""
        x, y = (xy - self.hips[:, :2]).T
        c, s = self.heading.T
        return c * x + s * y, self.side * (c * y - s * x)

    def nominal_on(self, terrain: NDArray[np.float32]) -> NDArray[np.float64]:
        """(m, 3) N_i in the world frame, at the terrain's heights (m,); where those are unknown on `ground`, in [m]."""
        found: NDArray[np.float64] = self.nominal.copy()
        height = np.where(np.isnan(terrain), self.ground, terrain)
        np.copyto(found[:, 2], height, where=np.isnan(found[:, 2]))
        return found

    def to_world(self, leg: Any, x: Any, y: Any) -> tuple[Any, Any]:
        """World x and y of points in the axes of the maps of `leg`, one or several, in [m]."""
        c, s = self.heading[leg].T
        left = y * self.side[leg]
        return self.hips[leg, 0] + c * x - s * left, self.hips[leg, 1] + s * x + c * left


class Body:
    """The robot's layout as arrays."""

    def __init__(self, layout: LegLayout) -> None:
        self._hips, self._feet = (
            np.array([points[leg] for leg in LEGS]) for points in (layout.hips, layout.nominal_feet)
        )
        self._side = np.array([-1.0 if is_right(leg) else 1.0 for leg in LEGS])

    def place(
        self, poses: NDArray[np.float64], legs: Sequence[str], nominal: Mapping[str, NDArray[np.float64]]
    ) -> LegFrames:
        """Frames of all legs at all poses, leg after leg, each leg's in the order of the poses.

        poses: (n, 6). nominal: leg -> (2,), (3,), (n, 2) or (n, 3) N_i in the world frame, in [m]; the nominal stance
        for legs not named.
        """
        count, chosen = len(poses), [LEGS.index(leg) for leg in legs]
        turns = np.array([_turns(pose) for pose in poses.tolist()])  # (n, 20)
        placed = np.empty((len(legs), count, 2, 3))  # L_i, N_i
        for part, points, turn in ((0, self._hips, turns[:, :9]), (1, self._feet, turns[:, 9:18])):
            np.matmul(points.take(chosen, axis=0), turn.reshape(-1, 3, 3), out=placed[:, :, part].swapaxes(0, 1))
        placed += poses[:, None, :3]
        hips, feet = placed.reshape(-1, 2, 3).swapaxes(0, 1)
        ground = feet[:, 2].copy()
        feet[:, 2] = np.nan
        for leg, point in nominal.items():
            if leg in legs:
                placed[legs.index(leg), :, 1, : point.shape[-1]] = point
        each = np.concatenate([turns] * len(legs))
        side = self._side.take(chosen).repeat(count)
        return LegFrames(
            legs=tuple(leg for leg in legs for _ in range(count)),
            side=side,
            hips=hips,
            heading=each[:, 9:11],
            roll=each[:, 18] * side,
            pitch=each[:, 19],
            nominal=feet,
            ground=ground,
        )


def _turns(pose: Sequence[float]) -> tuple[float, ...]:
    """Transposed rotations from the base to the world, of the whole pose and of its yaw alone, then roll and pitch.

    In scalars: for a handful of poses many times as fast as arrays. footholds.pose has the same as matrices.
    """
    *_, roll, pitch, yaw = pose
    cr, cp, cy = math.cos(roll), math.cos(pitch), math.cos(yaw)
    sr, sp, sy = math.sin(roll), math.sin(pitch), math.sin(yaw)
    return (
        *(cy * cp, sy * cp, -sp),
        *(cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr),
        *(cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr),
        *(cy, sy, 0.0),
        *(-sy, cy, 0.0),
        *(0.0, 0.0, 1.0),
        *(roll, pitch),
    )
