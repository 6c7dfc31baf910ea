"""Another shape for a trained network: fewer channels, those that the next layer hears most, or other inputs."""

from collections.abc import Mapping, Sequence

import torch
from torch import Tensor

#: FootNet's first layer on each cell alone; those after it are a convolution and its batch normalisation each.
_FIRST = "first"


def narrowed(weights: Mapping[str, Tensor], cells: Sequence[int]) -> dict[str, Tensor]:
    """Weights of FootNet with at most as many channels, `cells`, in the layers on each cell alone.

    A channel's worth is the length of its column in the next layer's weight, times by how much batch normalisation
    lets it vary: the magnitude criterion of Li, Kadav, Durdanovic, Samet and Graf, "Pruning Filters for Efficient
    ConvNets", ICLR 2017, for channels instead of filters. What is lost has to be learnt again.
    """
    found = dict(weights)
    for layer, count in enumerate(cells):
        following = [f"cells.{layer + 1}.0.weight"] if layer + 1 < len(cells) else _heads(found)
        worth = sum(found[name].float().square().sum(dim=(0, 2, 3)) for name in following)
        assert isinstance(worth, Tensor)
        normalisation = f"cells.{layer}.1.weight"
        if normalisation in found:
            worth = worth * found[normalisation].float().square()
        kept = worth.argsort(descending=True, stable=True)[:count].sort().values
        for name, tensor in found.items():
            if name in following:
                found[name] = torch.index_select(tensor, 1, kept)
            elif tensor.ndim and name.startswith(f"{_FIRST}." if layer == 0 else f"cells.{layer}."):
                found[name] = torch.index_select(tensor, 0, kept)
    return found


def with_inputs(weights: Mapping[str, Tensor], names: Sequence[str], wanted: Sequence[str]) -> dict[str, Tensor]:
    """Weights of FootNet that sees the numbers `wanted` of each cell instead of `names`, blind to the new ones."""
    first = weights[f"{_FIRST}.weight"]
    columns = [first[:, names.index(name)] if name in names else torch.zeros_like(first[:, 0]) for name in wanted]
    return {**weights, f"{_FIRST}.weight": torch.stack(columns, dim=1)}


def _heads(weights: Mapping[str, Tensor]) -> list[str]:
    """What reads the last of these layers, without context between."""
    return [name for name in ("head.weight", "reason_head.weight") if name in weights]
