"""Does the exported file answer as the trained network does? Compared cell by cell on many maps."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import onnx
import onnxruntime
import torch
from numpy.typing import NDArray
from torch import nn

from footsel.errors import ModelError
from footsel.exporting.trial_maps import TrialMaps
from footsel.footholds.cost import CLASSES, INFEASIBLE_CLASS, expected_cost, softmax
from footsel.footholds.encoding import InputEncoding
from footsel.runtime.contract import INPUT, LOGITS_OUTPUT
from footsel.runtime.network import COSTS, Network, session_options

#: Two classes whose logits are nearer than this are tied: float32 sums in another order may swap them.
TIE = 2e-4
#: The graph's decoding may differ by this from numpy's of the same logits: a probability, and a cost of 255.
MOST_INFEASIBLE_DIFFERENCE, MOST_COST_DIFFERENCE = 1e-5, 1e-3
DECODING_FIGURES = ("max_infeasible_difference", "max_cost_difference")
_BATCH = 50


@dataclass(frozen=True)
class Parity:
    """How far a file is from the network it was made of.

    maps, cells: what was compared. origin: where the maps are from.
    max_logit_difference: the largest over all cells and classes.
    class_differs: cells whose most probable class differs. class_differs_beyond_ties: those of them that are no tie.
    feasible_only_exported, feasible_only_trained: cells called feasible by one of the two alone.
    max_infeasible_difference, max_cost_difference: the file's own decoding against that of its logits in numpy.
    """

    maps: int
    cells: int
    origin: str
    max_logit_difference: float
    class_differs: int
    class_differs_beyond_ties: int
    feasible_only_exported: int
    feasible_only_trained: int
    max_infeasible_difference: float
    max_cost_difference: float

    def to_dict(self) -> dict[str, Any]:
        """JSON values of parity.json."""
        return asdict(self)


def trained_logits(trained: nn.Module, encoding: InputEncoding, maps: TrialMaps) -> NDArray[np.float32]:
    """(n, 14, 40, 40) answers of the trained network in torch, unsimplified."""
    parts = []
    for part in _slices(len(maps)):
        planes = encoding.encode(maps.heights[part], maps.roll[part], maps.pitch[part])
        with torch.no_grad():
            parts.append(trained(torch.from_numpy(planes)).numpy())
    return np.concatenate(parts)


def graph_logits(network: onnx.ModelProto, encoding: InputEncoding, maps: TrialMaps) -> NDArray[np.float32]:
    """(n, 14, 40, 40) answers of a graph maps -> logits that need not be a released file."""
    session = onnxruntime.InferenceSession(
        network.SerializeToString(), session_options(), providers=["CPUExecutionProvider"]
    )
    parts = []
    for part in _slices(len(maps)):
        planes = encoding.encode(maps.heights[part], maps.roll[part], maps.pitch[part])
        parts.append(session.run([LOGITS_OUTPUT], {INPUT: planes})[0])
    return np.concatenate(parts)


def compare(expected: NDArray[np.float32], exported: Network, maps: TrialMaps) -> Parity:
    """How far the exported file is from `expected`, the `trained_logits` of the same maps."""
    encoding = exported.contract.encoding
    parts = []
    for part in _slices(len(maps)):
        planes = encoding.encode(maps.heights[part], maps.roll[part], maps.pitch[part])
        parts.append(exported.run(planes, LOGITS_OUTPUT, *COSTS))
    found, infeasible, cost = (np.concatenate(output) for output in zip(*parts, strict=True))
    probabilities = softmax(found, axis=1)
    other_class = found.argmax(axis=1) != expected.argmax(axis=1)
    best_two = np.partition(expected, CLASSES - 2, axis=1)[:, -2:]
    decided = best_two[:, 1] - best_two[:, 0] > TIE
    feasible, expected_feasible = (
        share < exported.contract.feasible_below
        for share in (infeasible, softmax(expected, axis=1)[:, INFEASIBLE_CLASS])
    )
    return Parity(
        maps=len(maps),
        cells=maps.heights.size,
        origin=maps.origin,
        max_logit_difference=float(np.abs(found - expected).max()),
        class_differs=int(other_class.sum()),
        class_differs_beyond_ties=int((other_class & decided).sum()),
        feasible_only_exported=int((feasible & ~expected_feasible).sum()),
        feasible_only_trained=int((expected_feasible & ~feasible).sum()),
        max_infeasible_difference=float(np.abs(infeasible - probabilities[:, INFEASIBLE_CLASS]).max()),
        max_cost_difference=float(np.abs(cost - expected_cost(probabilities)).max()),
    )


def _slices(count: int) -> list[slice]:
    return [slice(start, start + _BATCH) for start in range(0, count, _BATCH)]


def require(parity: Parity, name: str) -> None:
    """Raise ModelError if a float32 export says another class than the trained network anywhere but in ties."""
    if parity.class_differs_beyond_ties:
        raise ModelError(
            f"{name} says another class than the trained network in {parity.class_differs_beyond_ties} of "
            f"{parity.cells} cells (largest logit difference {parity.max_logit_difference:.2g})",
            "nothing was written; report this with the versions of torch and onnxruntime",
        )


def require_decoding(parity: Parity, name: str) -> None:
    """Raise ModelError if a file of any variant decodes its own logits otherwise than footholds.cost."""
    within = (
        parity.max_infeasible_difference <= MOST_INFEASIBLE_DIFFERENCE
        and parity.max_cost_difference <= MOST_COST_DIFFERENCE
    )
    if not within:
        raise ModelError(
            f"{name} decodes its logits otherwise than numpy (p(infeasible) by {parity.max_infeasible_difference:.2g}, "
            f"cost by {parity.max_cost_difference:.2g})",
            "nothing was written; report this with the version of onnxruntime",
        )
