"""The fourth constraint: how far the foot can still move in its worst direction.

The margin is the distance of the foot's centre to the complement of the leg's self-collision-free workspace in the base
frame. Where the workspace's border crosses the edges of a 5 mm grid it is found to a tenth of a millimetre; distances
to these points, kept at the grid's nodes, answer in one trilinear look-up.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree
from tqdm import tqdm

from footsel.compiled import compiled
from footsel.oracle.overlap import COLLIDES, UNDECIDED
from footsel.oracle.self_collision import ExactSelfCollision, SelfCollisionTable
from footsel.robot.robot import Robot

#: Distance between nodes of the grid. [m]
VOXEL = 0.005

#: Halvings of an edge on the way to the border: it is found to 0.1 mm.
BISECTIONS = 5


@dataclass(frozen=True, eq=False)
class MarginField:
    """Signed distance to the border of the workspace, positive inside.

    distance: (a, b, c) float32 at the grid's nodes, in [m].
    origin: (3,) first node relative to the hip point, base axes, in [m].
    """

    distance: NDArray[np.float32]
    origin: NDArray[np.float64]

    @classmethod
    def build(cls, robot: Robot, leg: str, table: SelfCollisionTable) -> "MarginField":
        """Classify every node of the workspace's bounding box, find the border between them, measure to it."""
        kinematics = robot.kinematics[leg]
        angles = np.stack(np.meshgrid(*[np.linspace(low, high, 25) for low, high in kinematics.limits]), axis=-1)
        feet = kinematics.forward(angles).reshape(-1, 3)
        # Joint limits are sampled, so the box is a little small: two centimetres make up for it.
        low, high = feet.min(axis=0) - 0.02, feet.max(axis=0) + 0.02
        axes = [np.arange(a, b, VOXEL) for a, b in zip(low, high, strict=True)]
        workspace = _Workspace(robot, leg, table)
        inside = np.empty([len(axis) for axis in axes], dtype=np.bool_)
        plane = np.stack(np.meshgrid(axes[1], axes[2], indexing="ij"), axis=-1).reshape(-1, 2)
        for i, x in enumerate(tqdm(axes[0], desc=f"{leg} kinematic margin", leave=False, disable=None)):
            inside[i] = workspace.contains(np.column_stack([np.full(len(plane), x), plane])).reshape(inside.shape[1:])
        border = cKDTree(np.concatenate([workspace.border(inside, low, axis) for axis in range(3)]))
        # Two nodes beyond the border are all that interpolation inside can touch.
        near = ndimage.binary_dilation(inside, iterations=2)
        distance = np.full(inside.shape, -2 * VOXEL, dtype=np.float32)
        distance[near] = border.query(low + np.argwhere(near) * VOXEL, workers=-1)[0]
        distance[near & ~inside] *= -1
        return cls(distance, low)

    def look_up(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) margins at foot centres (k, 3) relative to the hip point in base axes, not below 0, in [m]."""
        return _margins(self.distance, self.origin, np.ascontiguousarray(points))

    @property
    def largest(self) -> float:
        """The largest margin of the workspace, in [m]."""
        return float(self.distance.max())


class _Workspace:
    """Foot centres, relative to the hip point in base axes, that are in kinematic range and free of self-collision."""

    def __init__(self, robot: Robot, leg: str, table: SelfCollisionTable) -> None:
        self._kinematics = robot.kinematics[leg]
        self._table = table
        self._exact = ExactSelfCollision(robot, leg)

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(k,) which points (k, 3) belong to it."""
        angles, inside = self._kinematics.inverse(points)
        angles = angles[inside]
        answers = self._table.look_up(angles)
        free, undecided = answers != COLLIDES, answers == UNDECIDED
        free[undecided] = ~self._exact.check(angles[undecided])
        inside[inside] = free
        return inside

    def border(self, inside: NDArray[np.bool_], origin: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
        """(k, 3) where the border crosses the grid's edges along one axis, by bisection."""
        first, second = (inside.take(range(a, inside.shape[axis] - 1 + a), axis) for a in (0, 1))
        crossing = np.argwhere(first != second)
        ahead = np.zeros(3)
        ahead[axis] = VOXEL
        start = origin + crossing * VOXEL
        starts_inside = first[tuple(crossing.T)]
        low, high = np.zeros(len(start)), np.ones(len(start))
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            same_side = self.contains(start + middle[:, None] * ahead) == starts_inside
            low, high = np.where(same_side, middle, low), np.where(same_side, high, middle)
        return np.asarray(start + ((low + high) / 2)[:, None] * ahead)


@compiled
def _margins(
    distance: NDArray[np.float32], origin: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:  # pragma: no cover - compiled
    """Trilinear interpolation."""
    margins = np.empty(len(points))
    for row in range(len(points)):
        total = 0.0
        fx = (points[row, 0] - origin[0]) / VOXEL
        fy = (points[row, 1] - origin[1]) / VOXEL
        fz = (points[row, 2] - origin[2]) / VOXEL
        i = min(max(int(fx), 0), distance.shape[0] - 2)
        j = min(max(int(fy), 0), distance.shape[1] - 2)
        k = min(max(int(fz), 0), distance.shape[2] - 2)
        for a in range(2):
            wx = fx - i if a else 1 - fx + i
            for b in range(2):
                wy = fy - j if b else 1 - fy + j
                for c in range(2):
                    wz = fz - k if c else 1 - fz + k
                    total += wx * wy * wz * distance[i + a, j + b, k + c]
        margins[row] = max(total, 0.0)
    return margins
