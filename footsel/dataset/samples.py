"""Labelled local maps, as they are kept in a shard and handed to training."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Heights are kept in steps of 0.1 mm, and labelled after this rounding, so a pair is exact.
HEIGHT_STEP = 1e-4
UNKNOWN_HEIGHT = -32768


@dataclass(frozen=True, eq=False)
class Samples:
    """n labelled local maps of one leg.

    heights_tenth_mm: (n, 40, 40) int16 terrain height relative to L_i in steps of 0.1 mm, -32768 = unknown.
    cost: (n, 40, 40) uint8 label, 255 = infeasible or unknown.
    reason: (n, 40, 40) uint8 footsel.footholds.Reason.
    pose: (n, 6) float32 base x, y, z, roll, pitch, yaw on its course, in [m] and [rad].
    family: (n,) terrain family names.
    course: (n,) int64 seed of the terrain course that the sample lies on.
    """

    heights_tenth_mm: NDArray[np.int16]
    cost: NDArray[np.uint8]
    reason: NDArray[np.uint8]
    pose: NDArray[np.float32]
    family: NDArray[np.str_]
    course: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.cost)

    @property
    def roll(self) -> NDArray[np.float32]:
        """(n,) roll of the base, in [rad]."""
        return self.pose[:, 3]

    @property
    def pitch(self) -> NDArray[np.float32]:
        """(n,) pitch of the base, in [rad]."""
        return self.pose[:, 4]

    def heights(self) -> NDArray[np.float32]:
        """(n, 40, 40) terrain height relative to L_i, NaN = unknown, in [m]."""
        return decode_heights(self.heights_tenth_mm)

    def take(self, index: ArrayLike | slice) -> "Samples":
        """The samples at `index` (slice, mask or integers)."""
        return Samples(**{field.name: getattr(self, field.name)[index] for field in fields(self)})

    def spread(self, count: int) -> "Samples":
        """At most `count` of the samples, evenly spread over all."""
        return self.take(np.linspace(0, len(self) - 1, min(count, len(self))).astype(np.intp))

    @classmethod
    def concatenate(cls, parts: Sequence["Samples"]) -> "Samples":
        """All samples of `parts`, in order."""
        return cls(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)})


def encode_heights(heights: ArrayLike) -> NDArray[np.int16]:
    """Metres to steps of 0.1 mm; NaN becomes UNKNOWN_HEIGHT. Heights beyond +-3.27 m are held there."""
    heights = np.asarray(heights, dtype=np.float64)
    steps = np.clip(np.rint(np.nan_to_num(heights) / HEIGHT_STEP), UNKNOWN_HEIGHT + 1, 32767)
    return np.where(np.isnan(heights), UNKNOWN_HEIGHT, steps).astype(np.int16)


def decode_heights(steps: NDArray[np.int16]) -> NDArray[np.float32]:
    """Steps of 0.1 mm to metres, unknown to NaN."""
    return np.where(steps == UNKNOWN_HEIGHT, np.nan, steps * HEIGHT_STEP).astype(np.float32)
