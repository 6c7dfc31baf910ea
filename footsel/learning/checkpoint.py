"""A run's files: a checkpoint to resume from and a model to use, both safetensors, both written all at once or not.

OUT/PAIR/checkpoint.safetensors   weights, moving average, optimiser state, random state, place in the training
OUT/PAIR/model.safetensors        the weights to use and, in its header, all that is needed to use them
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor, nn

from footsel.dataset.samples import Samples
from footsel.errors import InputError, ModelError
from footsel.files import replace_file
from footsel.footholds import LegLayout
from footsel.learning.batches import BatchEncoder
from footsel.learning.build import build_network
from footsel.learning.files import CHECKPOINT_FILE, MODEL_FILE
from footsel.learning.learner import Learner
from footsel.learning.network import FootholdNetwork, channels_last
from footsel.learning.predictions import Predict
from footsel.learning.recipe import Recipe
from footsel.learning.skeleton import LegSkeleton

_HEADER = "footsel"


@dataclass
class Progress:
    """Where a training stands: the next update, and the sums of the epoch so far.

    loss_sum: of the epoch's updates, weighted by their maps. seconds: spent in this epoch, interruptions not counted.
    """

    epoch: int = 0
    batch: int = 0
    loss_sum: float = 0.0
    maps: int = 0
    seconds: float = 0.0

    @property
    def mean_loss(self) -> float:
        """Training loss of the epoch so far."""
        return self.loss_sum / self.maps

    def add(self, loss: float, maps: int, seconds: float) -> None:
        """Count one update; `seconds` since the epoch began."""
        self.batch += 1
        self.loss_sum += loss * maps
        self.maps += maps
        self.seconds = seconds


def save_checkpoint(folder: Path, learner: Learner, progress: Progress) -> None:
    """Write everything that the rest of the training depends on, torch's random state included."""
    tensors = {f"net.{name}": tensor for name, tensor in learner.net.state_dict().items()}
    tensors |= {f"average.{name}": tensor for name, tensor in learner.average.items()}
    for index, state in learner.optimiser.state_dict()["state"].items():
        tensors |= {f"optimiser.{index}.{key}": tensor for key, tensor in state.items()}
    tensors["random"] = torch.get_rng_state()
    _save(folder / CHECKPOINT_FILE, tensors, vars(progress))


def load_checkpoint(folder: Path, learner: Learner) -> Progress:
    """Put a training back to where its checkpoint was written; the inverse of `save_checkpoint`."""
    tensors, progress = _load(folder / CHECKPOINT_FILE)
    learner.net.load_state_dict(_with_prefix(tensors, "net."))
    for name, tensor in _with_prefix(tensors, "average.").items():
        learner.average[name].copy_(tensor)
    state: dict[int, dict[str, Tensor]] = {}
    for name, tensor in _with_prefix(tensors, "optimiser.").items():
        index, key = name.split(".")
        state.setdefault(int(index), {})[key] = tensor
    # Adam's fused update walks weights and moments side by side in memory, so both must be stored the same way.
    for number, parameter in enumerate(learner.net.parameters()):
        for key in ("exp_avg", "exp_avg_sq"):
            state[number][key] = torch.empty_like(parameter).copy_(state[number][key]).detach()
    learner.optimiser.load_state_dict({**learner.optimiser.state_dict(), "state": state})
    torch.set_rng_state(tensors["random"])
    return Progress(**progress)


def save_model(folder: Path, weights: Mapping[str, Tensor], info: Mapping[str, Any]) -> None:
    """Write the weights to use with the JSON `info` in the header."""
    _save(folder / MODEL_FILE, weights, info)


def read_model(path: Path) -> tuple[dict[str, Tensor], dict[str, Any]]:
    """Weights and header of a model's file, a run's or a released one's.

    Raises ModelError for a file that is missing or no such file.
    """
    weights, info = _load(path)
    return {name: tensor.float() if tensor.is_floating_point() else tensor for name, tensor in weights.items()}, info


def released_weights(weights: Mapping[str, Tensor], info: Mapping[str, Any]) -> bytes:
    """Content of a file for a released model: what `read_model` reads, the kernels in bfloat16 for half the size."""
    small = {name: tensor.bfloat16() if tensor.ndim == 4 else tensor for name, tensor in weights.items()}
    return _content(small, info)


def load_network(folder: str | Path) -> tuple[FootholdNetwork, dict[str, Any]]:
    """The network of a run's folder OUT/PAIR, as of `read_network`."""
    return read_network(Path(folder) / MODEL_FILE)


def read_network(path: Path) -> tuple[FootholdNetwork, dict[str, Any]]:
    """The network of a model's file, a run's or a released one's, ready for inference, and what its header says.

    The header has: robot, pair, layout, skeleton, recipe, encoding, in_channels, classes, class_shares, dataset (what
    it was made with), dataset_sha256, seed, epochs_done, feasible_below, validation, version.
    Raises ModelError if there is no such model.
    """
    tensors, info = read_model(path)
    try:
        # Models of before there were skeletons have none.
        skeleton = info.get("skeleton") and LegSkeleton.from_dict(info["skeleton"])
        net = build_network(Recipe.from_dict(info["recipe"]), LegLayout.from_dict(info["layout"]), skeleton)
        net.load_state_dict(tensors)
    except (InputError, KeyError, RuntimeError, TypeError, ValueError):
        raise ModelError(f"{path} holds no network of this footsel", "train it again with this version") from None
    return channels_last(net).eval(), info


def network_predictor(net: nn.Module, encode: BatchEncoder) -> Predict:
    """Class probabilities of samples by a network in evaluation mode, in float32."""

    def predict(samples: Samples) -> NDArray[np.float32]:
        with torch.inference_mode():
            return np.asarray(torch.softmax(net(encode(samples)), dim=1).numpy())

    return predict


def _save(path: Path, tensors: Mapping[str, Tensor], header: Mapping[str, Any]) -> None:
    # Through bytes, not safetensors' own file writing, which makes files that only their owner can read.
    content = _content(tensors, header)
    replace_file(path, lambda temporary: temporary.write_bytes(content))


def _content(tensors: Mapping[str, Tensor], header: Mapping[str, Any]) -> bytes:
    # Convolution weights may be stored channels last; safetensors keeps plain row-major tensors.
    plain = {name: tensor.detach().contiguous() for name, tensor in tensors.items()}
    return bytes(save(plain, {_HEADER: json.dumps(header, sort_keys=True)}))


def _load(path: Path) -> tuple[dict[str, Tensor], dict[str, Any]]:
    try:
        with safe_open(path, framework="pt") as file:
            header: dict[str, Any] = json.loads((file.metadata() or {})[_HEADER])
            return {name: file.get_tensor(name) for name in file.keys()}, header  # noqa: SIM118
    except FileNotFoundError:
        raise ModelError(f"there is no {path}", "give the folder of one pair of a `footsel train` run") from None
    except (OSError, SafetensorError, KeyError, ValueError) as error:
        raise ModelError(f"{path} is damaged or foreign ({error})", "copy it again or train again") from None


def _with_prefix(tensors: Mapping[str, Tensor], prefix: str) -> dict[str, Tensor]:
    return {name[len(prefix) :]: tensor for name, tensor in tensors.items() if name.startswith(prefix)}
