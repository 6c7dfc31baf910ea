"""Labelled maps as network batches, encoded when they are needed: in memory a map stays 3 kB of steps of 0.1 mm."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from footsel.dataset.samples import Samples, decode_heights
from footsel.footholds.encoding import InputEncoding

_TILT_PLANES = ("roll", "pitch")


class BatchEncoder:
    """InputEncoding.encode for stored heights, by table.

    Every plane that depends on a cell alone is a function of its 16-bit height, so encoding all 65,536 heights once
    makes a batch a look-up, equal to InputEncoding.encode bit for bit.
    """

    def __init__(self, encoding: InputEncoding) -> None:
        self.encoding = encoding
        every_height = np.arange(-32768, 32768).astype(np.int16).reshape(1, 256, 256)
        self._tables = encoding.encode(decode_heights(every_height)).reshape(len(encoding.planes), -1)

    def __call__(self, samples: Samples) -> Tensor:
        """(n, planes, 40, 40) float32 input, stored channels last."""
        steps = samples.heights_tenth_mm
        index = steps.astype(np.int32) + 32768
        encoded = np.empty((*steps.shape, len(self.encoding.planes)), dtype=np.float32)
        for plane, name in enumerate(self.encoding.planes):
            if name not in _TILT_PLANES:
                encoded[..., plane] = self._tables[plane][index]
        # A tilt plane is constant over the map: one cell of it holds everything.
        one_cell = self.encoding.encode(np.zeros((len(steps), 1, 1)), samples.roll, samples.pitch)
        for plane, name in enumerate(self.encoding.planes):
            if name in _TILT_PLANES:
                encoded[..., plane] = one_cell[:, plane]
        return torch.from_numpy(encoded).permute(0, 3, 1, 2)


def shuffled_batches(count: int, batch_size: int, seed: int, epoch: int) -> list[NDArray[np.intp]]:
    """Indices of an epoch's batches, each sample once, in an order that depends on (seed, epoch) alone."""
    order = np.random.default_rng([seed, epoch]).permutation(count)
    return np.split(order, range(batch_size, count, batch_size))
