"""Layers that see the whole batch although each process holds a part of it.

Batch normalisation over a process's own maps would be another network for every number of processes: torch's
SyncBatchNorm runs on GPUs alone, so here is one for CPUs. Dropped channels are drawn for the whole batch by every
process, whose random states therefore stay equal and are those of a single process.
"""

import torch
from torch import Tensor, nn

from footsel.learning.precision import own_precision
from footsel.learning.ranks import Ranks


class SharedBatchNorm2d(nn.BatchNorm2d):
    """`norm` with mean and variance over the maps of all processes, in float32."""

    def __init__(self, norm: nn.BatchNorm2d, ranks: Ranks) -> None:
        super().__init__(norm.num_features, norm.eps, norm.momentum)
        self.load_state_dict(norm.state_dict())
        self._ranks = ranks

    def forward(self, input: Tensor) -> Tensor:
        """(n, channels, h, w), n of this process -> the same shape."""
        if not self.training:
            return super().forward(input)
        with own_precision():
            # Sums in float64, as torch's: the digits of a small variance beside a large mean.
            values, over = input.float(), (0, 2, 3)
            cells = values.new_tensor([input.numel() // self.num_features], dtype=torch.float64)
            sums = self._ranks.total(torch.cat([values.sum(over, dtype=torch.float64), cells]))
            mean, cells = sums[:-1] / sums[-1], sums[-1].detach()
            centred = values - mean.float()[:, None, None]
            variance = self._ranks.total(centred.square().sum(over, dtype=torch.float64)) / cells
            self._track(mean.float(), (variance * cells / (cells - 1)).float())
            scale = self.weight * (variance + self.eps).rsqrt().float()
            return (centred * scale[:, None, None] + self.bias[:, None, None]).to(input.dtype)

    @torch.no_grad()
    def _track(self, mean: Tensor, variance: Tensor) -> None:
        assert self.running_mean is not None and self.running_var is not None and self.momentum is not None
        self.running_mean.lerp_(mean, self.momentum)
        self.running_var.lerp_(variance, self.momentum)
        assert self.num_batches_tracked is not None
        self.num_batches_tracked.add_(1)


class SharedDropout2d(nn.Dropout2d):
    """Dropout whose random numbers are drawn for the maps of all processes, of which each uses its own."""

    def __init__(self, dropout: nn.Dropout2d, ranks: Ranks) -> None:
        super().__init__(dropout.p)
        self._ranks = ranks

    def forward(self, input: Tensor) -> Tensor:
        """(n, channels, h, w), n of this process -> the same shape."""
        if not self.training:
            return input
        maps = torch.zeros(self._ranks.count, dtype=torch.int64)
        maps[self._ranks.number] = len(input)
        maps = self._ranks.total(maps)
        kept = input.new_empty((int(maps.sum()), input.shape[1], 1, 1)).bernoulli_(1 - self.p).div_(1 - self.p)
        before = int(maps[: self._ranks.number].sum())
        return input * kept[before : before + len(input)]


def share_layers(net: nn.Module, ranks: Ranks) -> None:
    """Put these layers in place of torch's, in a network for several processes; weights and their names stay."""
    for name, child in net.named_children():
        if isinstance(child, nn.BatchNorm2d):
            setattr(net, name, SharedBatchNorm2d(child, ranks))
        elif isinstance(child, nn.Dropout2d):
            setattr(net, name, SharedDropout2d(child, ranks))
        else:
            share_layers(child, ranks)
