"""What every architecture has in common: local maps in, logits of fourteen classes out."""

from typing import TypeVar

import torch
from torch import Tensor, nn

from footsel.footholds.cost import CLASSES


class FootholdNetwork(nn.Module):
    """(n, in_channels, 40, 40) input planes -> (n, classes, 40, 40) logits, the last class is "infeasible"."""

    #: Name of the parameter that is added to every cell's logits, class by class.
    class_bias: str
    #: Names of the parts that need more than 8 bits: they tell millimetres apart.
    exact_parts: tuple[str, ...] = ()

    def __init__(self, in_channels: int) -> None:
        super().__init__()
        self.in_channels = in_channels
        self.classes = CLASSES

    def with_reasons(self, maps: Tensor) -> tuple[Tensor, Tensor]:
        """Logits of the classes and of the reasons (n, 5, 40, 40); of architectures that learn from reasons too."""
        raise NotImplementedError(f"{type(self).__name__} has no reasons")

    def drop_training_parts(self) -> None:
        """Leave out, in place, what no class depends on."""


Network = TypeVar("Network", bound=nn.Module)


def channels_last(net: Network) -> Network:
    """`net` with its convolution weights stored channels last, the faster layout on CPUs."""
    converted: Network = net.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    return converted
