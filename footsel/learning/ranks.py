"""Processes that train one network together: torchrun starts them, every batch is divided among them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import torch
import torch.distributed as dist
from torch import Tensor, nn
from torch.nn.parallel import DistributedDataParallel

from footsel.errors import InputError


@dataclass(frozen=True)
class Ranks:
    """Which process this is, of how many. number: from 0 to count - 1."""

    number: int = 0
    count: int = 1

    @property
    def first(self) -> bool:
        """Whether this is the process that judges, writes the files and talks."""
        return self.number == 0

    def share(self, maps: int) -> slice:
        """Which of a batch's maps are this process's: all processes' shares are its parts, as even as can be."""
        return slice(maps * self.number // self.count, maps * (self.number + 1) // self.count)

    def total(self, tensor: Tensor) -> Tensor:
        """Sum of all processes' tensors, the same in each; gradients flow back to all of them."""
        if self.count == 1:
            return tensor
        total: Tensor = _Total.apply(tensor)  # type: ignore[no-untyped-call]
        return total

    def parallel(self, net: nn.Module) -> nn.Module:
        """`net`, beginning with the first process's weights, its gradients averaged over the processes."""
        if self.count == 1:
            return net
        return DistributedDataParallel(net)

    def wait(self) -> None:
        """Until all processes have come here."""
        if self.count > 1:
            with _not_left_alone():
                dist.barrier()


#: The only process, as in every training without torchrun.
ALONE = Ranks()


@contextmanager
def ranks_of_torchrun() -> Iterator[Ranks]:
    """The processes that torchrun started together, connected until the context ends; without torchrun ALONE."""
    if not dist.is_torchelastic_launched() or int(os.environ["WORLD_SIZE"]) == 1:
        yield ALONE
        return
    dist.init_process_group("gloo")
    try:
        yield Ranks(dist.get_rank(), dist.get_world_size())
    finally:
        dist.destroy_process_group()


@contextmanager
def _not_left_alone() -> Iterator[None]:
    """A process that fails closes its connections; that is no error of ours to print a traceback for."""
    try:
        yield
    except RuntimeError as error:
        raise InputError(f"another process of this training ended ({error})", "see what it says, then resume") from None


class _Total(torch.autograd.Function):
    """Every process's output depends on every process's input, so the gradients are summed as the inputs are."""

    @staticmethod
    def forward(ctx: Any, tensor: Tensor) -> Tensor:  # noqa: ARG004
        return _summed(tensor)

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> Tensor:  # noqa: ARG004
        return _summed(gradients[0])


def _summed(tensor: Tensor) -> Tensor:
    total = tensor.clone(memory_format=torch.contiguous_format)
    with _not_left_alone():
        dist.all_reduce(total)
    return total
