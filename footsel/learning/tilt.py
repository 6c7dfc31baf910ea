"""The base's tilt as a network's fixed layers need it."""

import torch
from torch import Tensor

from footsel.footholds.encoding import TILT_RANGE


def tilt_matrix(roll: Tensor, pitch: Tensor) -> Tensor:
    """(n, 3, 3) from base to heading frame, Ry(pitch) Rx(roll), as footsel.footholds.pose.tilt_rotation.

    roll, pitch: (n, 1, 1, 1) tilt planes in [-1, 1].
    """
    roll, pitch = roll * TILT_RANGE, pitch * TILT_RANGE
    cos_roll, sin_roll, cos_pitch, sin_pitch = roll.cos(), roll.sin(), pitch.cos(), pitch.sin()
    entries = [cos_pitch, sin_pitch * sin_roll, sin_pitch * cos_roll]
    entries += [torch.zeros_like(roll), cos_roll, -sin_roll]
    entries += [-sin_pitch, cos_pitch * sin_roll, cos_pitch * cos_roll]
    return torch.cat(entries, dim=1).reshape(-1, 3, 3)


def turned(matrix: Tensor, vectors: Tensor) -> Tensor:
    """(n, m, ...) = matrix (n, m, k) times vectors (n, k, ...): one product for a whole map."""
    return (matrix @ vectors.flatten(2)).reshape(-1, matrix.shape[1], *vectors.shape[2:])
