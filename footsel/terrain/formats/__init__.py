"""Elevation map files, one module per format; packages beyond numpy are imported when a file needs them."""

from collections.abc import Sequence
from pathlib import Path

from footsel.errors import MapError
from footsel.terrain.elevation_map import ElevationMap
from footsel.terrain.formats import grid_map_bag, npz, png, point_cloud

BAG_SUFFIXES = (".bag", ".db3", ".mcap")
CLOUD_SUFFIXES = (".pcd", ".ply")
READABLE = (".npz", ".png", *BAG_SUFFIXES, "a ROS 2 bag folder", *CLOUD_SUFFIXES)


def load(
    path: str | Path,
    *,
    resolution: float | None = None,
    png_range: Sequence[float] | None = None,
    png_zero_unknown: bool = False,
    layer: str = "elevation",
) -> ElevationMap:
    """Read an elevation map; the suffix names the format. Options of other formats are ignored.

    path: `.npz`, `.png`, a ROS bag (`.bag`, `.db3`, `.mcap` or the folder of a ROS 2 bag), `.pcd` or `.ply`.
    resolution: cell side of an image (needed) or of the grid that a point cloud is laid on (2 cm if not given), in [m].
    png_range: heights of black and white of an image, in [m].
    png_zero_unknown: black pixels of an image are unknown.
    layer: layer of a GridMap.

    Raises MapError that names the file for one that is missing, damaged, of no known format or without a known
    cell, and MissingExtraError if the format needs a package that is not installed.
    """
    path = Path(path)
    try:
        elevation_map = _read(path, resolution, png_range, png_zero_unknown, layer)
        if not elevation_map.known.any():
            raise MapError("has no known cell: all heights are NaN", "record a map that has seen the ground")
    except MapError as error:
        raise MapError(f"{path}: {error.what}", error.remedy) from error
    except OSError as error:
        raise MapError(f"{path}: cannot be read ({error.strerror or error})", "check its permissions") from error
    return elevation_map


def _read(
    path: Path,
    resolution: float | None,
    png_range: Sequence[float] | None,
    png_zero_unknown: bool,
    layer: str,
) -> ElevationMap:
    suffix = path.suffix.lower()
    if not path.exists():
        raise MapError("no such file", "check the path")
    if path.is_dir():
        if not (path / "metadata.yaml").exists():
            raise MapError("is a folder without metadata.yaml", f"give a file or a bag: {', '.join(READABLE)}")
        return grid_map_bag.load(path, layer)
    path.open("rb").close()  # Permissions show here, not in the depths of a decoder.
    if suffix == ".npz":
        return npz.load(path)
    if suffix == ".png":
        return png.load(path, resolution, png_range, png_zero_unknown)
    if suffix in BAG_SUFFIXES:
        return grid_map_bag.load(path, layer)
    if suffix in CLOUD_SUFFIXES:
        return point_cloud.load(path, resolution)
    raise MapError(f"has the unknown suffix {suffix!r}", f"readable are {', '.join(READABLE)}")
