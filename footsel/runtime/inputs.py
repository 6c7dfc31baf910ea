"""Checks of what callers hand to the runtime: numeric, finite and of the expected shape."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from footsel.errors import InputError
from footsel.terrain import CELLS


def _as_numbers(what: str, values: ArrayLike, dtype: DTypeLike) -> NDArray[Any]:
    try:
        # Values beyond float32 turn infinite in the cast; callers refuse those.
        with np.errstate(over="ignore"):
            return np.asarray(values, dtype=dtype)
    except (TypeError, ValueError) as error:
        raise InputError(f"cannot read the {what} as numbers ({error})", "give floats") from None


def checked_heights(local_heights: ArrayLike) -> NDArray[np.float32]:
    """(40, 40) or (n, 40, 40) float32 heights, NaN allowed; raises InputError for anything else."""
    heights = _as_numbers("local heights", local_heights, np.float32)
    if heights.ndim not in (2, 3) or heights.shape[-2:] != (CELLS, CELLS) or heights.shape[0] == 0:
        raise InputError(
            f"local heights have shape {heights.shape}", f"expected ({CELLS}, {CELLS}) or (n, {CELLS}, {CELLS})"
        )
    if np.isinf(heights).any():
        raise InputError("local heights hold infinite values", "mark unknown cells with NaN")
    return heights


def checked_tilt(name: str, tilt: ArrayLike, maps: int) -> NDArray[np.float64]:
    """() or (maps,) finite angles, in [rad]; raises InputError for anything else."""
    angles = _as_numbers(name, tilt, np.float64)
    if angles.shape not in ((), (1,), (maps,)):
        raise InputError(f"{name} has shape {angles.shape}", f"expected one angle, or one for each of {maps} maps")
    if not np.isfinite(angles).all():
        raise InputError(f"{name} holds a value that is not finite", "give angles in rad")
    return angles
