"""Changes to a trained network that leave every output as it is: less to store, less to compute, easier to quantise."""

import copy
from collections.abc import Mapping

import torch
from torch import Tensor, nn
from torch.nn import functional

from footsel.learning.erfnet import Downsampler
from footsel.learning.network import FootholdNetwork
from footsel.terrain import CELLS


def simplified(network: nn.Module, in_channels: int) -> nn.Module:
    """A copy of the network in eval mode that computes the same logits for local maps of 40x40 cells."""
    network = copy.deepcopy(network).eval().to(memory_format=torch.contiguous_format)  # type: ignore[call-overload]
    if isinstance(network, FootholdNetwork):
        network.drop_training_parts()
    network = _replace_downsamplers(network)
    trim_padding_taps(network, torch.zeros(1, in_channels, CELLS, CELLS))
    return network


class FoldedDownsampler(nn.Module):
    """A downsampler whose normalisation went into the convolution, and into one scale and shift per pooled channel.

    The exporter folds a normalisation into the convolution before it, not into a concatenation. A quantised graph
    gains most: the normalisation would stand in it as an island of floats.
    """

    def __init__(self, source: Downsampler) -> None:
        super().__init__()
        norm, convolution = source.norm, source.convolution
        if norm.running_mean is None or norm.running_var is None:
            raise ValueError("a normalisation without running statistics cannot be folded")
        scale = norm.weight / torch.sqrt(norm.running_var + norm.eps)
        shift = norm.bias - scale * norm.running_mean
        convolved = convolution.out_channels
        pooled = len(scale) - convolved

        self.convolution = copy.deepcopy(convolution)
        self.pooling = source.pooling
        # A 1x1 convolution of each channel by itself keeps the blocked memory layout that a multiplication would break.
        self.affine = nn.Conv2d(pooled, pooled, 1, groups=pooled)
        with torch.no_grad():
            self.convolution.weight *= scale[:convolved, None, None, None]
            self.affine.weight.copy_(scale[convolved:, None, None, None])
            self.affine.bias.copy_(shift[convolved:])  # type: ignore[union-attr]
            bias = convolution.bias if convolution.bias is not None else torch.zeros(convolved)
            self.convolution.bias = nn.Parameter(scale[:convolved] * bias + shift[:convolved])

    def forward(self, maps: Tensor) -> Tensor:
        """As Downsampler in eval mode."""
        convolved = functional.relu(self.convolution(maps))
        return torch.cat([convolved, functional.relu(self.affine(self.pooling(maps)))], dim=1)


def _replace_downsamplers(module: nn.Module) -> nn.Module:
    if isinstance(module, Downsampler):
        return FoldedDownsampler(module)
    for name, child in module.named_children():
        setattr(module, name, _replace_downsamplers(child))
    return module


def trim_padding_taps(network: nn.Module, example: Tensor) -> int:
    """Remove, in place, the rows and columns of convolution weights that only ever meet zero padding.

    On an encoder that ends at 5x5, a tap 8 or 16 cells away reads nothing but padding.

    example: (1, planes, h, w) input of the only size that the network will see.
    Returns the number of weights removed.
    """
    removed = 0
    for convolution, sizes in _input_sizes(network, example).items():
        before = convolution.weight.numel()
        for axis, size in enumerate(sizes):
            _trim_axis(convolution, axis, size)
        removed += before - convolution.weight.numel()
    return removed


def _input_sizes(network: nn.Module, example: Tensor) -> Mapping[nn.Conv2d, tuple[int, int]]:
    """(h, w) of what every convolution with zero padding sees."""
    sizes: dict[nn.Conv2d, tuple[int, int]] = {}

    def record(module: nn.Module, inputs: tuple[Tensor, ...], _: Tensor) -> None:
        if isinstance(module, nn.Conv2d) and module.padding_mode == "zeros" and not isinstance(module.padding, str):
            sizes[module] = (inputs[0].shape[-2], inputs[0].shape[-1])

    hooks = [module.register_forward_hook(record) for module in network.modules()]
    try:
        with torch.no_grad():
            network(example)
    finally:
        for hook in hooks:
            hook.remove()
    return sizes


def _trim_axis(convolution: nn.Conv2d, axis: int, size: int) -> None:
    """Drop the outer taps of one axis that lie on padding for every output cell."""
    kernel, stride = convolution.kernel_size[axis], convolution.stride[axis]
    padding, dilation = int(convolution.padding[axis]), convolution.dilation[axis]
    outputs = (size + 2 * padding - dilation * (kernel - 1) - 1) // stride + 1
    used = [
        tap
        for tap in range(kernel)
        if any(0 <= cell * stride + tap * dilation - padding < size for cell in range(outputs))
    ]
    # Padding is one number for both sides of an axis, so the same number of taps goes from each.
    cut = min(used[0], kernel - 1 - used[-1]) if used else 0
    if cut == 0:
        return
    weight = convolution.weight.detach().narrow(2 + axis, cut, kernel - 2 * cut)
    convolution.weight = nn.Parameter(weight.clone())
    convolution.kernel_size = _with_axis(convolution.kernel_size, axis, kernel - 2 * cut)
    convolution.padding = _with_axis(
        (int(convolution.padding[0]), int(convolution.padding[1])), axis, padding - cut * dilation
    )
    if kernel - 2 * cut == 1:
        convolution.dilation = _with_axis(convolution.dilation, axis, 1)


def _with_axis(pair: tuple[int, ...], axis: int, value: int) -> tuple[int, int]:
    """`pair` with its entry of this axis replaced."""
    return (value, pair[1]) if axis == 0 else (pair[0], value)
