"""What a fixed layer computes with."""

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import nn


def keep_constant(layer: nn.Module, name: str, value: ArrayLike) -> None:
    """A float32 buffer of the layer: it goes where the layer goes, but into no file, for it follows from the robot."""
    layer.register_buffer(name, torch.from_numpy(np.asarray(value, dtype=np.float32)), persistent=False)
