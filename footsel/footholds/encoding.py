"""What a network sees of a local map: image planes in [0, 1] or [-1, 1]. Training and runtime share this code."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import InputError
from footsel.terrain.codec import HEIGHT_RANGE, heights_to_image, quantise_image, rises_to_image

#: height: the depth image; unknown: 1 where no height is known; roll, pitch: constant planes, 1 at TILT_RANGE;
#: above: by how much the ground rises above L_i, which the depth image cuts off, in the same unit.
PLANES = ("height", "unknown", "roll", "pitch", "above")

#: Tilt that a constant plane shows as 1. [rad]
TILT_RANGE = float(np.deg2rad(15.0))


@dataclass(frozen=True)
class InputEncoding:
    """Which planes a network takes, in this order.

    quantised: heights are rounded to 8 bits, as in the paper.
    height_range: depth below L_i, or rise above it, that an image shows as 1, in [m].
    """

    planes: tuple[str, ...] = ("height",)
    quantised: bool = True
    height_range: float = HEIGHT_RANGE

    def __post_init__(self) -> None:
        object.__setattr__(self, "planes", tuple(self.planes))
        if not self.planes or any(plane not in PLANES for plane in self.planes):
            raise InputError(f"input planes {self.planes}", f"choose from: {', '.join(PLANES)}")

    def encode(self, heights: ArrayLike, roll: ArrayLike = 0.0, pitch: ArrayLike = 0.0) -> NDArray[np.float32]:
        """Network input (n, planes, 40, 40) float32.

        heights: (n, 40, 40) terrain height relative to L_i, NaN = unknown, in [m].
        roll, pitch: (n,) or scalar tilt of the base, in [rad].
        """
        heights = np.asarray(heights, dtype=np.float32)
        encoded = np.empty((heights.shape[0], len(self.planes), *heights.shape[1:]), dtype=np.float32)
        for plane, values in zip(self.planes, encoded.swapaxes(0, 1), strict=True):
            if plane in ("height", "above"):
                to_image = heights_to_image if plane == "height" else rises_to_image
                image = to_image(heights, self.height_range, out=values)
                if self.quantised:
                    values[...] = quantise_image(image) / np.float32(255)
            elif plane == "unknown":
                values[...] = np.isnan(heights)
            else:
                tilt = np.asarray(roll if plane == "roll" else pitch, dtype=np.float32) / np.float32(TILT_RANGE)
                values[...] = tilt.reshape(-1, 1, 1)
        return encoded

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values; `from_dict` is its inverse."""
        return {**asdict(self), "planes": list(self.planes)}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "InputEncoding":
        """From the JSON values of `to_dict`."""
        return cls(tuple(values["planes"]), bool(values["quantised"]), float(values["height_range"]))
