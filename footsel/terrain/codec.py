"""Metres to network images and back (DESIGN: value = clip((z_Li - z_cell) / range, 0, 1))."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: The paper's normalisation constant for ANYmal, section III-C; other robots scale it with their reach. [m]
HEIGHT_RANGE = 0.85


def heights_to_image(
    heights: ArrayLike, height_range: float = HEIGHT_RANGE, out: NDArray[np.float32] | None = None
) -> NDArray[np.float32]:
    """Depth below the hip point as a share of the range: 0 at or above L_i, 1 at the range and below, 1 for unknown.

    heights: (..., n, n) terrain height relative to L_i, NaN = unknown, in [m]. out: where the image goes.
    """
    image = np.divide(np.asarray(heights, dtype=np.float32), np.float32(-height_range), out=out)
    # Of NaN and a number these take the number.
    np.fmin(image, np.float32(1), out=image)
    return np.asarray(np.fmax(image, np.float32(0), out=image))


def rises_to_image(
    heights: ArrayLike, height_range: float = HEIGHT_RANGE, out: NDArray[np.float32] | None = None
) -> NDArray[np.float32]:
    """Rise above the hip point as a share of the range: 0 at or below L_i, 1 at the range and above, 0 for unknown.

    What the depth image cuts off: there a wall as high as the hip is like one twice as high, which a hip meets earlier.
    heights, out: as in `heights_to_image`.
    """
    image = np.divide(np.asarray(heights, dtype=np.float32), np.float32(height_range), out=out)
    np.fmax(image, np.float32(0), out=image)
    return np.asarray(np.fmin(image, np.float32(1), out=image))


def quantise_image(image: ArrayLike) -> NDArray[np.uint8]:
    """The paper's 8-bit grey image: value * 255, rounded."""
    return np.asarray(np.rint(np.asarray(image, dtype=np.float32) * np.float32(255)), dtype=np.uint8)


def image_to_heights(image: ArrayLike, height_range: float = HEIGHT_RANGE) -> NDArray[np.float32]:
    """Heights relative to L_i that an image in [0, 1] stands for; what was clipped or unknown is lost, in [m]."""
    return np.asarray(-np.asarray(image, dtype=np.float32) * np.float32(height_range))
