"""Narrow holes of a map count as obstacles: seams and shadows beside an edge, over which no limb should be bold."""

from functools import lru_cache

import numpy as np
from scipy import ndimage

from footsel.terrain import ElevationMap

#: Holes narrower than this are filled: what a scan misses between two blocks. [m]
NARROW = 0.10


@lru_cache(maxsize=2)
def without_narrow_holes(elevation_map: ElevationMap) -> ElevationMap:
    """A copy in which cells of narrow holes are as high as the highest known cell that may reach into them.

    Wider holes, and what lies beyond the known ground, stay unknown.
    """
    # A hole is narrow if no window of so many cells lies wholly in it.
    size = max(round(NARROW / elevation_map.resolution / 2 - 0.5), 0) * 2 + 1
    known = elevation_map.known
    if size == 1 or known.all():
        return elevation_map
    near = ndimage.maximum_filter(known, size, mode="constant", cval=0)
    narrow = ndimage.minimum_filter(near, size, mode="constant", cval=1) & ~known
    heights = elevation_map.elevation
    highest = ndimage.maximum_filter(np.where(known, heights, -np.inf), size, mode="nearest")
    return ElevationMap(np.where(narrow, highest, heights), elevation_map.resolution, elevation_map.position)
