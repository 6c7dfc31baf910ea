"""Does the exported file answer as the trained network does? Compared cell by cell on many maps, by several engines."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import onnx
import onnxruntime
import torch
from numpy.typing import NDArray
from torch import nn

from footsel.errors import ModelError
from footsel.exporting.engines import Engine, Logits, other_engines
from footsel.exporting.trial_maps import TrialMaps
from footsel.footholds.cost import CLASSES, INFEASIBLE_CLASS, expected_cost, softmax
from footsel.runtime.contract import INPUT, LOGITS_OUTPUT
from footsel.runtime.network import COSTS, Network, session_options

#: What logits should agree to; cells that do not are counted.
TOLERANCE = 1e-4
#: Two classes whose logits are nearer than this are tied: float32 sums in another order may swap them.
TIE = 2e-4
#: Share of the cells that may be of another class without being a tie: where a network amplifies the rounding of its
#: first layers, one cell in millions differs by more. A graph that computes something else differs in thousands.
MOST_OTHER_CLASSES = 1e-6
#: The graph's decoding may differ by this from numpy's of the same logits: a probability, and a cost of 255.
MOST_INFEASIBLE_DIFFERENCE, MOST_COST_DIFFERENCE = 1e-5, 1e-3
DECODING_FIGURES = ("max_infeasible_difference", "max_cost_difference")


def torch_logits(trained: nn.Module) -> Logits:
    """Of the trained network in torch, unsimplified."""

    def run(planes: NDArray[np.float32]) -> NDArray[np.float32]:
        with torch.inference_mode():
            return np.asarray(trained(torch.from_numpy(planes)).numpy())

    return run


def graph_logits(network: onnx.ModelProto) -> Logits:
    """Of a graph maps -> logits that need not be a released file, in onnxruntime."""
    session = onnxruntime.InferenceSession(
        network.SerializeToString(), session_options(), providers=["CPUExecutionProvider"]
    )
    return lambda planes: np.asarray(session.run([LOGITS_OUTPUT], {INPUT: planes})[0])


@dataclass
class LogitDifferences:
    """How far one engine's logits are from the trained network's.

    maps, cells: what was compared. max_logit_difference: the largest over all cells and classes.
    cells_beyond_tolerance: cells with a logit that differs by more than TOLERANCE.
    class_differs: cells whose most probable class differs. class_differs_beyond_ties: those of them that are no tie.
    """

    maps: int = 0
    cells: int = 0
    max_logit_difference: float = 0.0
    cells_beyond_tolerance: int = 0
    class_differs: int = 0
    class_differs_beyond_ties: int = 0

    def update(self, found: NDArray[np.float32], expected: NDArray[np.float32]) -> None:
        """Add (n, 14, 40, 40) logits."""
        difference = np.abs(found - expected).max(axis=1)
        likeliest = expected.argmax(axis=1)
        other_class = found.argmax(axis=1) != likeliest
        self.maps += len(found)
        self.cells += difference.size
        self.max_logit_difference = max(self.max_logit_difference, float(difference.max()))
        self.cells_beyond_tolerance += int((difference > TOLERANCE).sum())
        self.class_differs += int(other_class.sum())
        best_two = np.partition(expected.transpose(0, 2, 3, 1)[other_class], CLASSES - 2, axis=1)[:, -2:]
        self.class_differs_beyond_ties += int((best_two[:, 1] - best_two[:, 0] > TIE).sum())


class Parity:
    """One exported file beside the network it was made of, a batch of maps at a time."""

    def __init__(self, content: bytes, name: str, maps: int, engines: Sequence[Engine] = ()) -> None:
        """content: of the file that messages call `name`. maps: how many it will meet. engines: more to compare."""
        self.name = name
        self._exported = Network.from_bytes(content, name)
        self.logits = LogitDifferences()
        self._others = [(engine, LogitDifferences()) for engine in (*other_engines(content, maps), *engines)]
        self._feasible_only_exported = self._feasible_only_trained = 0
        self._max_infeasible_difference = self._max_cost_difference = 0.0

    def update(self, maps: TrialMaps, planes: NDArray[np.float32], expected: NDArray[np.float32]) -> None:
        """Add n maps. planes: (n, planes, 40, 40) of them. expected: (n, 14, 40, 40) the trained network's logits."""
        found, infeasible, cost = self._exported.answers(maps.heights, maps.roll, maps.pitch, LOGITS_OUTPUT, *COSTS)
        self.logits.update(found, expected)
        for engine, differences in self._others:
            few = _left(engine, differences, len(maps))
            if few:
                differences.update(engine.logits(planes[:few]), expected[:few])
        feasible, expected_feasible = (
            share < self._exported.contract.feasible_below
            for share in (infeasible, softmax(expected, axis=1)[:, INFEASIBLE_CLASS])
        )
        self._feasible_only_exported += int((feasible & ~expected_feasible).sum())
        self._feasible_only_trained += int((expected_feasible & ~feasible).sum())
        probabilities = softmax(found, axis=1)
        self._max_infeasible_difference = max(
            self._max_infeasible_difference, _furthest(infeasible, probabilities[:, INFEASIBLE_CLASS])
        )
        self._max_cost_difference = max(self._max_cost_difference, _furthest(cost, expected_cost(probabilities)))

    def require_classes(self) -> None:
        """Raise ModelError if a float32 export says another class than the trained network in more than ties."""
        if self.logits.class_differs_beyond_ties > MOST_OTHER_CLASSES * self.logits.cells:
            raise ModelError(
                f"{self.name} says another class than the trained network in {self.logits.class_differs_beyond_ties} "
                f"of {self.logits.cells} cells (largest logit difference {self.logits.max_logit_difference:.2g})",
                "nothing was written; report this with the versions of torch and onnxruntime",
            )

    def require_decoding(self) -> None:
        """Raise ModelError if a file of any variant decodes its own logits otherwise than footholds.cost."""
        if (
            self._max_infeasible_difference > MOST_INFEASIBLE_DIFFERENCE
            or self._max_cost_difference > MOST_COST_DIFFERENCE
        ):
            raise ModelError(
                f"{self.name} decodes its logits otherwise than numpy (p(infeasible) by "
                f"{self._max_infeasible_difference:.2g}, cost by {self._max_cost_difference:.2g})",
                "nothing was written; report this with the version of onnxruntime",
            )

    def to_dict(self, origin: str) -> dict[str, Any]:
        """JSON values of parity.json; the figures of onnxruntime, in which the file runs, are not nested.

        origin: where the maps are from. feasible_only_exported, feasible_only_trained: cells called feasible by one of
        the two alone. max_infeasible_difference, max_cost_difference: the file's own decoding against that of its
        logits in numpy. other_engines: name -> LogitDifferences.
        """
        return {
            **asdict(self.logits),
            "origin": origin,
            "tolerance": TOLERANCE,
            "feasible_only_exported": self._feasible_only_exported,
            "feasible_only_trained": self._feasible_only_trained,
            "max_infeasible_difference": self._max_infeasible_difference,
            "max_cost_difference": self._max_cost_difference,
            "other_engines": {engine.name: asdict(differences) for engine, differences in self._others},
        }


def _left(engine: Engine, differences: LogitDifferences, maps: int) -> int:
    """How many of so many maps an engine still takes."""
    return maps if engine.maps is None else min(maps, engine.maps - differences.maps)


def _furthest(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    return float(np.abs(a - b).max())
