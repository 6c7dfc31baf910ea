"""Height images: 8- or 16-bit grey `.png`, black at the lower end of a height range and white at the upper.

Orientation is grid_map's, as in its image tools and viewers: the top row of the picture lies at the +x side of the map
and its left column at the +y side. Seen from above with x upwards, the map looks as the picture does.
Pixels that are more than half transparent are unknown, as there.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footsel.errors import MapError
from footsel.terrain.elevation_map import ElevationMap
from footsel.terrain.formats.decoding import decoding

#: Differences between red, green and blue up to here are what is left of an editor's colour profile, not a colour.
COLOUR_CAST = 4


def load(
    path: Path, resolution: float | None, png_range: Sequence[float] | None, png_zero_unknown: bool
) -> ElevationMap:
    """Read a height image whose cell side and height range (low, high) in [m] the caller knows.

    png_zero_unknown: black pixels are unknown instead of low.
    """
    if png_range is None:
        raise MapError("is an image without metres", "give the heights of black and white (--png-range LOW HIGH)")
    if resolution is None:
        raise MapError("is an image without a cell size", "give it in metres (--resolution R)")
    if len(png_range) != 2 or not np.isfinite(png_range).all() or png_range[0] >= png_range[1]:
        raise MapError(f"height range is {tuple(png_range)}", "expected two heights in metres, LOW below HIGH")
    low, high = png_range
    grey, opaque, white = _read_grey(path)
    known = opaque & (grey > 0) if png_zero_unknown else opaque
    heights = np.where(known, low + grey * ((high - low) / white), np.nan)
    return ElevationMap(heights[::-1, ::-1].astype(np.float32), resolution)


def _read_grey(path: Path) -> tuple[NDArray[np.float64], NDArray[np.bool_], int]:
    """Grey values (rows, columns), which pixels are opaque, and the value of white."""
    with decoding("PNG image", package="Pillow"):
        from PIL import Image

        with Image.open(path, formats=["PNG"]) as image:
            # 16-bit grey is mode I;16, or I in older versions of Pillow.
            if image.mode.startswith("I"):
                grey = np.asarray(image, dtype=np.float64)
                return grey, np.ones(grey.shape, dtype=bool), 65535
            colours = np.asarray(image.convert("RGBA"), dtype=np.int16)
            grey = np.asarray(image.convert("L"), dtype=np.float64)
    if np.ptp(colours[..., :3], axis=-1).max() > COLOUR_CAST:
        raise MapError("is a colour image", "expected grey values that stand for heights")
    return grey, colours[..., 3] >= 128, 255
