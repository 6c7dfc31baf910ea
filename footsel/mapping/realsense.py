"""What an Intel RealSense D435 makes of a scene whose true depth is known."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from footsel.errors import InputError
from footsel.mapping.camera import CameraModel
from footsel.mapping.depth_noise import StereoNoise
from footsel.terrain.degradation import LATERAL, NEAREST

Image = NDArray[np.float32]

#: Width of the images that Intel recommends for depth, in [px], the field of view and the distance of the imagers.
NATIVE_WIDTH = 848
FIELD_OF_VIEW = float(np.deg2rad(87.0))
BASELINE = 0.05
#: Focal length at that width, in [px].
FOCAL_PX = NATIVE_WIDTH / (2 * np.tan(FIELD_OF_VIEW / 2))
#: Standard deviation of the disparity, Intel's figure for a well textured scene, and the step it is given in, in [px].
SUBPIXEL, DISPARITY_STEP = 0.08, 1 / 32
#: Readings are whole millimetres. [m]
DEPTH_STEP = 0.001
#: The farthest reading that elevation mapping with this camera usually takes. [m]
FARTHEST = 3.25
#: Errors are shared by squares of so many native pixels: an assumption; the matching windows overlap.
WINDOW_PX = 6


@dataclass(frozen=True)
class D435:
    """The depth camera, read at a part of its width; nothing else of the camera is simulated.

    width, height: of the image, in pixels; the field of view is 87 degrees wide at any width.

    - Noise of the disparity, `sigma_z = z^2 s / (f B)`, shared by neighbouring pixels, in steps of 1/32 px and of 1 mm.
    - Fraying: beside an edge a pixel may show the neighbouring surface, or something between the two. How far from the
      edge, is the published lateral noise of this camera.
    - Dropouts: what only the left imager sees, to the left of all that stands out, has no depth; nor has what is nearer
      than 0.28 m or farther than 3.25 m.
    """

    width: int = 424
    height: int = 240

    def __post_init__(self) -> None:
        if min(self.width, self.height) < 2:
            raise InputError(f"an image of {self.width}x{self.height} pixels", "expected at least 2x2")

    @cached_property
    def camera(self) -> CameraModel:
        """Intrinsics and noise, as a map needs them."""
        focal = FOCAL_PX / self._native
        return CameraModel(
            self.width,
            self.height,
            focal,
            focal,
            (self.width - 1) / 2,
            (self.height - 1) / 2,
            StereoNoise(SUBPIXEL, FOCAL_PX, BASELINE),
            NEAREST,
            FARTHEST,
            self._shared,
        )

    def read(self, depth: NDArray[np.floating], rng: np.random.Generator) -> Image:
        """(height, width) what the camera gives for a true depth image, in [m]; 0 is no reading.

        depth: (height, width) along the optical axis, in [m]; infinite where there is nothing.
        """
        if np.shape(depth) != (self.height, self.width):
            raise InputError(f"a depth image of shape {np.shape(depth)}", f"expected ({self.height}, {self.width})")
        with np.errstate(divide="ignore"):
            true = (FOCAL_PX * BASELINE / np.asarray(depth, dtype=np.float64)).astype(np.float32)
        disparity = self._frayed(true, rng) + SUBPIXEL * self._shared_normal(rng)
        disparity = np.rint(disparity / DISPARITY_STEP) * DISPARITY_STEP
        seen = (disparity > 0) & ~self._hidden_from_the_right(true)
        reading = FOCAL_PX * BASELINE / np.where(seen, disparity, np.inf)
        reading = np.rint(reading / DEPTH_STEP) * DEPTH_STEP
        return self.camera.readings(reading)

    @property
    def _native(self) -> float:
        """Native pixels in one of the image's, along one side."""
        return NATIVE_WIDTH / self.width

    @property
    def _shared(self) -> int:
        return max(1, round(WINDOW_PX / self._native))

    def _shared_normal(self, rng: np.random.Generator) -> Image:
        """(height, width) of unit variance, the same within each window."""
        side = self._shared
        few = rng.standard_normal((-(-self.height // side), -(-self.width // side)), dtype=np.float32)
        return few.repeat(side, axis=0).repeat(side, axis=1)[: self.height, : self.width]

    def _frayed(self, disparity: Image, rng: np.random.Generator) -> Image:
        """Each pixel shows the plane that one nearby lies on: planes, of linear disparity, stay as they are."""
        spread = LATERAL * FOCAL_PX / self._native
        v, u = np.indices(disparity.shape)
        down, right = (np.rint(spread * self._shared_normal(rng)).astype(np.intp) for _ in range(2))
        other = np.clip(v + down, 0, self.height - 1), np.clip(u + right, 0, self.width - 1)
        fall, slope = (_lesser_difference(disparity, axis)[other] for axis in (0, 1))
        there = disparity[other]
        frayed = there + fall * (v - other[0]) + slope * (u - other[1])
        # Not nearer than both surfaces, nor farther: a plane does not go on behind what ends it.
        bounds = np.minimum(there, disparity), np.maximum(there, disparity)
        return np.asarray(np.clip(frayed, *bounds), dtype=np.float32)

    def _hidden_from_the_right(self, disparity: Image) -> NDArray[np.bool_]:
        """(height, width) where the right imager sees a pixel from further right at the same place or left of it."""
        place = np.arange(self.width, dtype=np.float32) * self._native - disparity
        rightwards = np.minimum.accumulate(place[:, ::-1], axis=1)[:, ::-1]
        return np.asarray(place > rightwards)


def _lesser_difference(image: Image, axis: int) -> Image:
    """To the next or from the last pixel, whichever is less: on either side of an edge, that of the surface there."""
    difference = np.diff(image, axis=axis)
    ahead = np.concatenate([difference, np.take(difference, [-1], axis=axis)], axis=axis)
    behind = np.concatenate([np.take(difference, [0], axis=axis), difference], axis=axis)
    return np.where(np.abs(ahead) < np.abs(behind), ahead, behind)
