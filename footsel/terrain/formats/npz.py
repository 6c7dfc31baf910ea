"""Elevation map `.npz`: the keys `elevation`, `resolution` and, if not centred on the world's origin, `position`."""

import zipfile
from pathlib import Path

import numpy as np

from footsel.errors import MapError
from footsel.files import replace_file
from footsel.terrain.elevation_map import ElevationMap
from footsel.terrain.formats.decoding import decoding


def load(path: Path) -> ElevationMap:
    """Read the three keys; others are never read, and nothing is unpickled."""
    if not zipfile.is_zipfile(path):
        raise MapError("is not an .npz file", "the file is damaged or of another format")
    with decoding("elevation map .npz"), np.load(path, allow_pickle=False) as archive:
        missing = {"elevation", "resolution"} - set(archive.files)
        if missing:
            raise MapError(
                f"lacks {' and '.join(sorted(missing))}", f"expected elevation and resolution, found {archive.files}"
            )
        elevation, resolution = archive["elevation"], archive["resolution"]
        position = archive["position"] if "position" in archive.files else np.zeros(2)
    if resolution.size != 1:
        raise MapError(f"resolution has shape {resolution.shape}", "expected one number, the cell side in metres")
    return ElevationMap(elevation, resolution.item(), position)


def save(elevation_map: ElevationMap, path: str | Path) -> None:
    """Write the map; a file of that name is replaced only when the new one is complete."""
    path = Path(path)

    def write(temporary: Path) -> None:
        # Through a file, as numpy adds .npz to a name that has another suffix.
        with temporary.open("wb") as file:
            np.savez_compressed(
                file,
                elevation=elevation_map.elevation,
                resolution=np.float64(elevation_map.resolution),
                position=elevation_map.position,
            )

    try:
        replace_file(path, write)
    except OSError as error:
        raise MapError(
            f"cannot write {path} ({error.strerror})", "choose a folder that exists and is writable"
        ) from None
