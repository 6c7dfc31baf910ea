"""Point clouds, `.pcd` and `.ply`, gridded to an elevation map.

A foot meets the top of what is in a cell, so a cell takes a high point of it: the highest of up to five points, and the
90th percentile of more, which a single flying point beside an edge does not move. A cell without a point is unknown.
Overhangs and ceilings are not told from ground: crop the cloud first.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footsel.errors import MapError
from footsel.terrain.elevation_map import ElevationMap
from footsel.terrain.formats import pcd
from footsel.terrain.formats.decoding import decoding

DEFAULT_RESOLUTION = 0.02
PERCENTILE = 0.9
#: A cloud with a stray point far away would make a map that fits no memory.
MOST_CELLS = 25_000_000


def load(path: Path, resolution: float | None) -> ElevationMap:
    """Read a cloud in [m], z up, and grid it at `resolution` [m], 2 cm if not given."""
    if path.suffix.lower() == ".pcd":
        with decoding("PCD point cloud"):
            points = pcd.read_points(path)
    else:
        points = _read_ply(path)
    return grid_points(points, DEFAULT_RESOLUTION if resolution is None else resolution)


def grid_points(points: NDArray[np.float64], resolution: float) -> ElevationMap:
    """Elevation map of points (n, 3) in the world frame, cell borders on whole multiples of `resolution` [m]."""
    if not (np.isfinite(resolution) and resolution > 0):
        raise MapError(f"resolution is {resolution}", "expected a cell side above 0 m (--resolution R)")
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        raise MapError("has no finite point", "record a cloud with x, y and z in metres")
    index = np.floor(points[:, :2] / resolution)
    low = index.min(axis=0)
    shape = index.max(axis=0) - low + 1
    if shape.prod() > MOST_CELLS:
        extent = " x ".join(f"{cells * resolution:.0f}" for cells in shape)
        raise MapError(f"spans {extent} m", "crop the cloud, remove stray points or give a larger --resolution")
    nx, ny = (int(cells) for cells in shape)
    cell = np.ravel_multi_index((index - low).astype(np.intp).T, (nx, ny))
    order = np.lexsort((points[:, 2], cell))
    filled, first, count = np.unique(cell[order], return_index=True, return_counts=True)
    elevation = np.full(nx * ny, np.nan, dtype=np.float32)
    elevation[filled] = points[order, 2][first + np.rint(PERCENTILE * (count - 1)).astype(np.intp)]
    return ElevationMap(elevation.reshape(nx, ny), resolution, (low + shape / 2) * resolution)


def _read_ply(path: Path) -> NDArray[np.float64]:
    """(n, 3) vertices of a PLY file, ASCII or binary."""
    with decoding("PLY point cloud", package="plyfile"):
        from plyfile import PlyData

        ply = PlyData.read(path)
        if "vertex" not in ply or not {"x", "y", "z"} <= set(ply["vertex"].data.dtype.names):
            raise MapError("has no vertices with x, y and z", "export a point cloud")
        return np.stack([np.asarray(ply["vertex"][axis], dtype=np.float64) for axis in "xyz"], axis=-1)
