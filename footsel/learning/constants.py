"""What a fixed layer computes with."""

import numpy as np
import torch
from numpy.typing import ArrayLike, DTypeLike
from torch import nn


def keep_constant(layer: nn.Module, name: str, value: ArrayLike, dtype: DTypeLike = np.float32) -> None:
    """A buffer of the layer: it goes where the layer goes, but into no file, for it follows from the robot."""
    layer.register_buffer(name, torch.from_numpy(np.asarray(value, dtype=dtype)), persistent=False)
