"""A training that goes on from a released model: the ONNX file is folded and trimmed, here it is unfolded again.

So a network can learn in several sittings from nothing but what is released. Batch normalisation was folded into the
convolutions before it. Each norm is set to undo, on the maps at hand, what its statistics would do, so the network
computes the released function both by running and by batch statistics, and goes on learning from there.
"""

from pathlib import Path

import numpy as np
import onnx
import torch
from torch import Tensor, nn

from footsel.dataset import Samples
from footsel.errors import ModelError
from footsel.learning.erfnet import Downsampler, ERFNet
from footsel.learning.learner import Learner
from footsel.runtime.model_folder import checksum, find_model_folder, load_networks, network_file

#: Maps from which the statistics of the norms are taken.
STATISTICS_MAPS = 512


def lineage(model: str | Path, pair: str) -> dict[str, str]:
    """What a model that begins with a released one says of it: the file's hash, and what that was trained on."""
    folder = find_model_folder(model)
    contract = load_networks(folder)[pair].contract
    return {
        "sha256": checksum((folder / network_file(pair)).read_bytes()),
        "dataset_sha256": contract.dataset_sha256,
        "recipe": contract.recipe,
        "version": contract.version,
    }


def start_from_release(learner: Learner, model: str | Path, pair: str, samples: Samples) -> None:
    """Give a fresh learner the weights of a released model's float32 network.

    model: name or folder of a released model. samples: training maps, some of which set the norms' statistics.
    Raises ModelError if the model is of another architecture or input.
    """
    folder = find_model_folder(model)
    contract = load_networks(folder)[pair].contract
    if contract.encoding.planes != learner.encode.encoding.planes:
        raise ModelError(
            f"{folder} sees {', '.join(contract.encoding.planes)}, the recipe {learner.encode.encoding.planes}",
            "continue with a recipe of the same planes",
        )
    graph = onnx.load_model(folder / network_file(pair)).graph
    released = {
        tensor.name: torch.from_numpy(onnx.numpy_helper.to_array(tensor).copy()) for tensor in graph.initializer
    }
    some = samples.take(np.linspace(0, len(samples) - 1, min(STATISTICS_MAPS, len(samples))).astype(np.intp))
    net = ERFNet(learner.net.in_channels, learner.net.classes)
    try:
        _unfold(net, released, learner.encode(some))
    except (KeyError, RuntimeError) as error:
        raise ModelError(f"{folder} is no plain ERFNet of this footsel ({error})", "train from the beginning") from None
    learner.adopt(net.state_dict())


@torch.no_grad()
def _unfold(net: ERFNet, released: dict[str, Tensor], maps: Tensor) -> None:
    scale_and_shift: dict[nn.Module, tuple[Tensor, Tensor]] = {}
    for name, module in net.named_modules():
        if isinstance(module, nn.Conv2d | nn.ConvTranspose2d):
            module.weight.copy_(_with_padding_taps(released[f"{name}.weight"], module.weight))
            module.bias.copy_(released[f"{name}.bias"])  # type: ignore[union-attr]
        elif isinstance(module, Downsampler):
            # The convolved channels carry the norm in their weights, the pooled ones in an affine map of their own.
            convolved = module.convolution.out_channels
            scale = torch.cat([torch.ones(convolved), released[f"{name}.affine.weight"].flatten()])
            shift = torch.cat([torch.zeros(convolved), released[f"{name}.affine.bias"]])
            scale_and_shift[module.norm] = scale, shift

    def undo(norm: nn.Module, inputs: tuple[Tensor]) -> None:
        assert isinstance(norm, nn.BatchNorm2d)
        variance, mean = torch.var_mean(inputs[0], dim=(0, 2, 3), correction=0)
        scale, shift = scale_and_shift.get(norm, (torch.ones_like(mean), torch.zeros_like(mean)))
        norm.running_mean.copy_(mean)  # type: ignore[union-attr]
        norm.running_var.copy_(variance)  # type: ignore[union-attr]
        norm.weight.copy_(scale * torch.sqrt(variance + norm.eps))
        norm.bias.copy_(shift + scale * mean)

    norms = [module for module in net.modules() if isinstance(module, nn.BatchNorm2d)]
    hooks = [norm.register_forward_pre_hook(undo) for norm in norms]
    try:
        net.eval()(maps)
    finally:
        for hook in hooks:
            hook.remove()


def _with_padding_taps(weight: Tensor, like: Tensor) -> Tensor:
    """`weight` with zeros for the outer taps that the export left out because they only ever met padding."""
    padding: list[int] = []
    for size, wanted in zip(reversed(weight.shape[2:]), reversed(like.shape[2:]), strict=True):
        padding += [(wanted - size) // 2] * 2
    return nn.functional.pad(weight, padding)
