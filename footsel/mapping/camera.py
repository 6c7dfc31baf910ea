"""A depth camera: which ray a pixel looks along, and how good its reading is."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import InputError
from footsel.mapping.depth_noise import DepthNoise


@dataclass(frozen=True, eq=False)
class CameraModel:
    """A pinhole camera; its frame has x to the right of the image, y down and z along the optical axis.

    width, height: of the image, in pixels. fx, fy: focal lengths, cx, cy: principal point, in [px]; the centre of the
    first pixel is (0, 0). noise: of its depth. nearest, farthest: depths it can measure, in [m].
    shared_px: side of the squares of pixels whose errors are the same, as the matching windows of a stereo camera
    overlap; averages over many pixels are the worse for it.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    noise: DepthNoise
    nearest: float = 0.0
    farthest: float = np.inf
    shared_px: int = 1

    def __post_init__(self) -> None:
        if min(self.width, self.height, self.shared_px) < 1:
            raise InputError(f"a camera of {self.width}x{self.height} pixels", "expected at least one")
        numbers = (self.fx, self.fy, self.cx, self.cy, self.nearest)
        if not np.isfinite(numbers).all() or min(self.fx, self.fy) <= 0:
            raise InputError(f"focal lengths {self.fx}, {self.fy}", "expected finite numbers above 0, in pixels")
        if not 0 <= self.nearest < self.farthest:
            raise InputError(f"a range of {self.nearest} to {self.farthest} m", "expected 0 <= nearest < farthest")

    @cached_property
    def rays(self) -> NDArray[np.float32]:
        """(3, height * width) point of each pixel at depth 1, row by row, in the camera's frame."""
        v, u = np.indices((self.height, self.width), dtype=np.float64)
        ones = np.ones_like(u)
        rays = np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, ones])
        return rays.reshape(3, -1).astype(np.float32)

    def project(self, points: NDArray[np.floating]) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
        """Pixels (..., 2) as (u, v) and depths (...,) of points (..., 3) in the camera's frame; NaN behind it."""
        depth = points[..., 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = np.where(depth > 0, 1 / depth, np.nan)
        u = points[..., 0] * inverse * self.fx + self.cx
        v = points[..., 1] * inverse * self.fy + self.cy
        return np.stack([u, v], axis=-1), depth

    def readings(self, depth: ArrayLike) -> NDArray[np.float32]:
        """(height, width) a depth image with 0 for all that is no reading: NaN, infinite, or out of range, in [m].

        Raises InputError for another shape or what are no numbers.
        """
        try:
            image = np.asarray(depth, dtype=np.float32)
        except (TypeError, ValueError) as error:
            raise InputError(f"a depth image that is not numeric ({error})", "give floats in metres") from None
        if image.shape != (self.height, self.width):
            raise InputError(f"a depth image of shape {image.shape}", f"expected ({self.height}, {self.width})")
        usable = (image > 0) & (image >= self.nearest) & (image <= self.farthest) & (image < np.inf)
        return np.where(usable, image, np.float32(0))
