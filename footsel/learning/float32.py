"""Parts of a network that keep full precision where the rest may be rounded."""

from contextlib import AbstractContextManager, nullcontext

import torch


def float32() -> AbstractContextManager[object]:
    """Arithmetic in float32 even under autocast; nothing without it, so that an exported graph shows no trace."""
    if torch.is_autocast_enabled("cpu"):
        return torch.autocast("cpu", enabled=False)
    return nullcontext()
