"""Parts of a network that keep their precision where the rest may be rounded."""

from contextlib import AbstractContextManager, nullcontext

import torch


def own_precision() -> AbstractContextManager[object]:
    """Arithmetic in the tensors' own types even under autocast; nothing without it, so no exported graph shows it."""
    if torch.is_autocast_enabled("cpu"):
        return torch.autocast("cpu", enabled=False)
    return nullcontext()
