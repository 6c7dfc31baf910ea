"""A map whose heights cannot be metres in the base's world frame is answered, but not in silence."""

import warnings

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import LegLayout

#: Ground this many height ranges above or below every hip is no ground a leg has to do with.
_IMPLAUSIBLE = 10
#: Every so many cells are looked at: a wrong unit shows in all of them.
_STEP = 37


class UnitWarning:
    """Warns once, at the first map that is known around the legs and nowhere near them."""

    def __init__(self, layout: LegLayout) -> None:
        self._limit = np.float32(_IMPLAUSIBLE * layout.height_range)
        self._given = False

    def check(self, heights: NDArray[np.float32]) -> None:
        """heights: (m, 40, 40) relative to the hip points, NaN = unknown, in [m]."""
        some = np.abs(heights.reshape(-1)[::_STEP])
        if self._given or (some < self._limit).any() or np.isnan(some).all():
            return
        self._given = True
        warnings.warn(
            f"the terrain under the legs is {np.nanmin(some):.3g} m or more above or below the hips: is the elevation "
            "map in metres, and in the frame of the base pose?",
            UserWarning,
            stacklevel=5,  # the caller of `select`
        )
