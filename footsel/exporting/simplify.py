"""Changes to a trained network that leave every output as it is: less to store, less to compute, easier to quantise."""

import copy
from collections.abc import Mapping
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from footsel.learning.erfnet import Downsampler, FirstConvolution, Upsampler
from footsel.learning.network import FootholdNetwork
from footsel.terrain import CELLS


def simplified(network: nn.Module, in_channels: int) -> nn.Module:
    """A copy of the network in eval mode that computes the same logits for local maps of 40x40 cells."""
    network = copy.deepcopy(network).eval().to(memory_format=torch.contiguous_format)  # type: ignore[call-overload]
    if isinstance(network, FootholdNetwork):
        network.drop_training_parts()
    network = _replace_downsamplers(network)
    fold_normalisations(network)
    trim_padding_taps(network, torch.zeros(1, in_channels, CELLS, CELLS))
    return network


class FoldedDownsampler(nn.Module):
    """A downsampler whose normalisation went into the convolution, and into one scale and shift per pooled channel.

    A quantised graph gains most: the normalisation would stand in it as an island of floats.
    """

    def __init__(self, source: Downsampler) -> None:
        super().__init__()
        convolved = source.convolution.out_channels
        pooled = source.norm.num_features - convolved
        # A 1x1 convolution of each channel by itself keeps the blocked memory layout that a multiplication would break.
        affine = nn.Conv2d(pooled, pooled, 1, groups=pooled)
        with torch.no_grad():
            affine.weight.fill_(1)
            affine.bias.zero_()  # type: ignore[union-attr]
        self.convolution = folded(source.convolution, _channels(source.norm, slice(convolved)))
        self.pooling = source.pooling
        self.affine = folded(affine, _channels(source.norm, slice(convolved, None)))

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


def _channels(norm: nn.BatchNorm2d, channels: slice) -> nn.BatchNorm2d:
    """The normalisation of these channels alone."""
    values = {name: value[channels] for name, value in norm.state_dict().items() if value.dim() > 0}
    part = nn.BatchNorm2d(len(values["weight"]), eps=norm.eps).eval()
    part.load_state_dict(values, strict=False)
    return part


def fold_normalisations(network: nn.Module) -> None:
    """Put, in place, every normalisation that follows a convolution in a row of layers into that convolution."""
    for module in network.modules():
        if not isinstance(module, nn.Sequential | Upsampler):
            continue
        for (before, convolution), (name, norm) in pairwise(list(module.named_children())):
            if isinstance(norm, nn.BatchNorm2d) and isinstance(convolution, nn.Conv2d | nn.ConvTranspose2d):
                setattr(module, before, folded(convolution, norm))
                setattr(module, name, nn.Identity())


def folded(convolution: nn.Conv2d | nn.ConvTranspose2d, norm: nn.BatchNorm2d) -> nn.Conv2d | nn.ConvTranspose2d:
    """One convolution for both, rounded once, and not at all if it sums up in float64.

    An exporter that folds in float32 adds as much as half of what float32 loses anyway.
    """
    exact = copy.deepcopy(convolution).eval().double()
    both = fuse_conv_bn_eval(exact, copy.deepcopy(norm).eval().double(), isinstance(exact, nn.ConvTranspose2d))
    if not isinstance(both, FirstConvolution):
        both.float()
    return both


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
