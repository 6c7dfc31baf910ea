"""The terrain of a local map as triangles, for engines that do not take coal's height field."""

from dataclasses import dataclass
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

from footsel.terrain import LocalMap

#: Unknown cells, and the lower edge of the walls around the map, lie this far below the lowest known cell. [m]
DEPTH = 1.0


@dataclass(frozen=True, eq=False)
class TerrainMesh:
    """The surface of the ground in the heading frame, with walls down to the floor around the map.

    vertices: (v, 3) in [m]; triangles: (t, 3) indices, the ground's first and seen from above counter-clockwise.
    heights: (n, n) of the vertices of the ground, unknown cells at the floor, in [m]. resolution: in [m].
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.intp]
    heights: NDArray[np.float64]
    resolution: float

    @classmethod
    def of(cls, local_map: LocalMap) -> "TerrainMesh":
        """Vertices are cell centres; the square between four of them is split from (i, j) to (i + 1, j + 1)."""
        n, d = local_map.cells, local_map.resolution
        heights = local_map.heights.astype(np.float64)
        floor = float(np.nanmin(heights)) - DEPTH
        heights = np.where(np.isnan(heights), floor, heights)
        along = (np.arange(n) - (n - 1) / 2) * d
        x, y = np.meshgrid(along, along, indexing="ij")
        ground = np.stack([x, y, heights], axis=-1).reshape(-1, 3)
        index = np.arange(n * n).reshape(n, n)
        a, b, c, e = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
        top = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, e])])

        rim = np.concatenate([index[:-1, 0], index[-1, :-1], index[:0:-1, -1], index[0, :0:-1]])
        lower = n * n + np.arange(len(rim))
        skirt = ground[rim] * [1, 1, 0] + [0, 0, floor]
        after, lower_after = np.roll(rim, -1), np.roll(lower, -1)
        walls = np.concatenate([np.column_stack([rim, lower, after]), np.column_stack([after, lower, lower_after])])
        return cls(np.concatenate([ground, skirt]), np.concatenate([top, walls]), heights, d)

    def height(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(k,) height of the ground over or under points (k, 2 or more), -inf beyond the map, in [m]."""
        n = len(self.heights)
        u = points[:, :2] / self.resolution + (n - 1) / 2
        on_map = ((u >= 0) & (u <= n - 1)).all(axis=1)
        i, j = np.clip(np.floor(u[:, 0]), 0, n - 2).astype(int), np.clip(np.floor(u[:, 1]), 0, n - 2).astype(int)
        a, b = u[:, 0] - i, u[:, 1] - j
        near, far = self.heights[i, j], self.heights[i + 1, j + 1]
        # The triangle with the corner (i + 1, j) where a > b, with (i, j + 1) elsewhere.
        corner = np.where(a > b, self.heights[i + 1, j], self.heights[i, j + 1])
        first, second = np.maximum(a, b), np.minimum(a, b)
        surface = near + first * (corner - near) + second * (far - corner)
        return np.where(on_map, surface, -np.inf)

    def below(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(k,) whether points (k, 3) are under the ground: so is a body that cuts no triangle if its centre is."""
        return np.asarray(points[:, 2] < self.height(points))


def triangle_model(vertices: NDArray[np.float64], triangles: NDArray[np.intp]) -> Any:
    """coal's model of triangles (t, 3) among vertices (v, 3)."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), len(vertices))
    model.addVertices(np.ascontiguousarray(vertices, dtype=np.float64))
    model.addTriangles(np.ascontiguousarray(triangles, dtype=np.int64))
    model.endModel()
    model.computeLocalAABB()
    return model
