"""What an export begins with: a pair's network of a training run, or that of a released model folder.

A release keeps its kernels in half the bits to train on from, but its ONNX file has them as they were trained: that
graph is taken over, so a release that is exported again answers as before.
"""

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import onnx
import torch
from torch import nn

from footsel.errors import ModelError
from footsel.exporting.align import aligned
from footsel.exporting.decoding import without_decoding
from footsel.exporting.engines import Logits
from footsel.exporting.onnx_file import strip, to_onnx
from footsel.exporting.parity import DECODING_FIGURES, graph_logits, torch_logits
from footsel.exporting.simplify import simplified
from footsel.learning.checkpoint import load_network, read_network, released_weights
from footsel.learning.files import weights_file
from footsel.runtime.model_folder import PARITY_FILE, SUMS_FILE, network_file, read_checked


@dataclass(frozen=True, eq=False)
class Source:
    """One pair's network, ready to be exported.

    info: header of its weights (footsel.learning.checkpoint). weights: content of the released weights' file.
    model: encoded maps -> logits, simplified. exact_parts: names of its parts that need more than 8 bits.
    logits: the answers that every exported file is compared with.
    trained: the network in torch; None if it is a release, whose weights are rounded.
    comparison: figures of parity.json that an earlier export found for the logits of `model`, against torch.
    """

    info: Mapping[str, Any]
    weights: bytes
    model: onnx.ModelProto
    exact_parts: Collection[str]
    logits: Logits
    trained: nn.Module | None = None
    comparison: Mapping[str, Any] = field(default_factory=dict)


def open_source(folder: Path, pair: str) -> Source:
    """A pair's network of a run or of a model folder.

    Raises ModelError if the network is missing, damaged or of the other pair.
    """
    source = _released(folder, pair) if (folder / SUMS_FILE).is_file() else _trained(folder / pair)
    if source.info["pair"] != pair:
        raise ModelError(f"{folder / pair} was trained for the {source.info['pair']} legs", f"put the {pair} run there")
    return source


def _trained(folder: Path) -> Source:
    network, info = load_network(folder)
    with torch.no_grad():
        model = aligned(to_onnx(simplified(network, network.in_channels), network.in_channels))
    return Source(
        info=info,
        weights=released_weights(network.state_dict(), info),
        model=model,
        exact_parts=network.exact_parts,
        logits=torch_logits(network),
        trained=network,
    )


def _released(folder: Path, pair: str) -> Source:
    weights, network = weights_file(pair), network_file(pair)
    contents = read_checked(folder, keep=(weights, network, PARITY_FILE))
    trained, info = read_network(folder / weights)
    model = without_decoding(onnx.load_from_string(contents[network]))
    strip(model)
    return Source(
        info=info,
        weights=contents[weights],
        model=model,
        exact_parts=trained.exact_parts,
        logits=graph_logits(model),
        comparison=_comparison(contents[PARITY_FILE], pair),
    )


def _comparison(parity: bytes, pair: str) -> dict[str, Any]:
    figures = json.loads(parity).get(pair, {}).get("float32", {})
    # The decoding is another one than that of the earlier file.
    return {name: value for name, value in figures.items() if name not in DECODING_FIGURES}
