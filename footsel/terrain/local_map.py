"""The 40x40 map under one leg, in that leg's heading frame H."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import MapError
from footsel.terrain.elevation_map import ElevationMap

CELLS = 40
#: Side of the world-aligned window that the paper cuts before it rotates and crops (section III-C).
PAPER_WINDOW_CELLS = 51


@dataclass(frozen=True, eq=False)
class LocalMap:
    """Terrain around the point M_i below a leg's hip point L_i, in the heading frame H.

    heights: (n, n) float32 terrain height relative to L_i, i along H's x and j along H's y, NaN = unknown, in [m].
    resolution: side of a cell, in [m].
    hip: (3,) L_i in the world frame, in [m].
    yaw: heading of H in the world frame, in [rad].
    """

    heights: NDArray[np.float32]
    resolution: float
    hip: NDArray[np.float64]
    yaw: float

    def __post_init__(self) -> None:
        heights = np.ascontiguousarray(self.heights, dtype=np.float32)
        hip = np.asarray(self.hip, dtype=np.float64)
        if heights.ndim != 2 or heights.shape[0] != heights.shape[1]:
            raise MapError(f"local map has shape {heights.shape}", "expected a square array")
        if np.isinf(heights).any():
            raise MapError("local map holds infinite heights", "mark unknown cells with NaN")
        if hip.shape != (3,):
            raise MapError(f"hip point has shape {hip.shape}", "expected (3,)")
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "hip", hip)

    @property
    def cells(self) -> int:
        """Cells along one side."""
        return int(self.heights.shape[0])

    @property
    def known(self) -> NDArray[np.bool_]:
        """(n, n) which cells have a height."""
        return ~np.isnan(self.heights)

    def positions(self) -> NDArray[np.float64]:
        """(n, n, 3) contact point of each cell in the world frame, z NaN where unknown, in [m]."""
        xy = self.hip[:2] + cell_offsets(self.cells, self.resolution) @ _rotation(self.yaw).T
        z = self.hip[2] + self.heights.astype(np.float64)
        return np.concatenate([xy, z[..., None]], axis=-1)

    def distances_to(self, xy: ArrayLike) -> NDArray[np.float64]:
        """(n, n) horizontal distance of each cell centre to a world point, in [m]."""
        in_heading = _rotation(self.yaw).T @ (np.asarray(xy, dtype=np.float64) - self.hip[:2])
        return np.asarray(np.linalg.norm(cell_offsets(self.cells, self.resolution) - in_heading, axis=-1))


def cell_offsets(cells: int, resolution: float) -> NDArray[np.float64]:
    """(n, n, 2) cell centres from M_i in the heading frame: (i - 19.5, j - 19.5) * resolution for n = 40, in [m]."""
    along = (np.arange(cells) - (cells - 1) / 2) * resolution
    return np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1)


def extract_local_map(
    elevation_map: ElevationMap, hip: ArrayLike, yaw: float, resolution: float, cells: int = CELLS
) -> LocalMap:
    """Sample the world map at the cell centres of the local map of a leg whose hip point is `hip` (3,) in W."""
    hip = np.asarray(hip, dtype=np.float64)
    xy = hip[:2] + cell_offsets(cells, resolution) @ _rotation(yaw).T
    heights = elevation_map.sample(xy).astype(np.float64) - hip[2]
    return LocalMap(heights.astype(np.float32), resolution, hip, yaw)


def extract_local_map_as_paper(
    elevation_map: ElevationMap, hip: ArrayLike, yaw: float, resolution: float, cells: int = CELLS
) -> LocalMap:
    """Cut a world-aligned 51x51 window around M_i, rotate it by the yaw and crop it, as the paper does (section III-C).

    Cells that the rotation takes from beyond the window are unknown, a few in each corner at 45 degrees.
    """
    cell_ratio = resolution / elevation_map.resolution
    window_cells = int(np.ceil(PAPER_WINDOW_CELLS * cell_ratio)) | 1
    window = elevation_map.window(np.asarray(hip, dtype=np.float64)[:2], window_cells)
    return extract_local_map(window, hip, yaw, resolution, cells)


def _rotation(yaw: float) -> NDArray[np.float64]:
    """(2, 2) rotation from the heading frame to the world's xy plane."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s], [s, c]])
