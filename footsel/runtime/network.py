"""One ONNX network and its contract: encoded local maps in, and for every cell what is asked for: scores, or cost."""

import re
from pathlib import Path

import numpy as np
import onnxruntime
from numpy.typing import ArrayLike, NDArray

from footsel.errors import ModelError
from footsel.footholds.cost import softmax
from footsel.runtime.contract import COST_OUTPUT, INFEASIBLE_OUTPUT, INPUT, LOGITS_OUTPUT, ModelContract
from footsel.terrain import CELLS

#: The outputs that a choice needs.
COSTS = (INFEASIBLE_OUTPUT, COST_OUTPUT)

#: Maps per call of onnxruntime: what a layer makes of more falls out of a core's own cache, and two cores that call at
#: a time wait for the one that they share.
BATCH = 2


class Network:
    """An onnxruntime session that keeps what its contract says. Safe to call from several threads at once."""

    def __init__(self, session: onnxruntime.InferenceSession, contract: ModelContract) -> None:
        self.contract = contract
        self._session = session

    @classmethod
    def load(cls, path: str | Path) -> "Network":
        """Read an exported `.onnx` file; raises ModelError if it is missing, damaged, foreign or off its contract."""
        path = Path(path)
        try:
            content = path.read_bytes()
        except OSError as error:
            raise ModelError(
                f"cannot read model {path} ({error.strerror})", "give a file of `footsel export`"
            ) from None
        return cls.from_bytes(content, str(path))

    @classmethod
    def from_bytes(cls, content: bytes, source: str) -> "Network":
        """As `load`, from the content of the file that messages call `source`."""
        try:
            session = onnxruntime.InferenceSession(content, session_options(), providers=["CPUExecutionProvider"])
        # A damaged file meets one of a dozen onnxruntime errors whose only common base is Exception.
        except Exception as error:
            raise _unreadable(error, source) from None
        contract = ModelContract.from_metadata(session.get_modelmeta().custom_metadata_map, source)
        _check_shapes(session, contract, source)
        return cls(session, contract)

    def logits(self, heights: ArrayLike, roll: ArrayLike = 0.0, pitch: ArrayLike = 0.0) -> NDArray[np.float32]:
        """(n, 14, 40, 40) scores before the softmax; arguments as in `answers`."""
        return self.answers(heights, roll, pitch, LOGITS_OUTPUT)[0]

    def probabilities(self, heights: ArrayLike, roll: ArrayLike = 0.0, pitch: ArrayLike = 0.0) -> NDArray[np.float32]:
        """(n, 14, 40, 40) probability of each class, the last is "infeasible"; arguments as in `answers`."""
        return softmax(self.logits(heights, roll, pitch), axis=1)

    def costs(
        self, heights: ArrayLike, roll: ArrayLike = 0.0, pitch: ArrayLike = 0.0
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(n, 40, 40) probability of "infeasible", and mean cost over all classes; arguments as in `answers`."""
        infeasible, cost = self.answers(heights, roll, pitch, *COSTS)
        return infeasible, cost

    def answers(
        self, heights: ArrayLike, roll: ArrayLike, pitch: ArrayLike, *outputs: str
    ) -> list[NDArray[np.float32]]:
        """The named outputs of the graph for n local maps, in batches of the best size.

        heights: (n, 40, 40) terrain height relative to the trained leg's L_i, NaN = unknown, in [m].
        roll, pitch: (n,) or scalar tilt of the base, in [rad].
        """
        heights = np.asarray(heights)
        if len(heights) <= BATCH:
            return self.run(self.encode(heights, roll, pitch), *outputs)
        rolls, pitches = (np.broadcast_to(np.asarray(tilt).reshape(-1), len(heights)) for tilt in (roll, pitch))
        parts = []
        for start in range(0, len(heights), BATCH):
            part = slice(start, start + BATCH)
            parts.append(self.run(self.encode(heights[part], rolls[part], pitches[part]), *outputs))
        return [np.concatenate(output) for output in zip(*parts, strict=True)]

    def run_in_batches(self, planes: NDArray[np.float32], *outputs: str) -> list[NDArray[np.float32]]:
        """As `run`, in batches of the best size."""
        if len(planes) <= BATCH:
            return self.run(planes, *outputs)
        parts = [self.run(planes[start : start + BATCH], *outputs) for start in range(0, len(planes), BATCH)]
        return [np.concatenate(output) for output in zip(*parts, strict=True)]

    def run(self, planes: NDArray[np.float32], *outputs: str) -> list[NDArray[np.float32]]:
        """The named outputs of the graph for encoded maps (n, planes, 40, 40)."""
        results: list[NDArray[np.float32]] = self._session.run(outputs, {INPUT: planes})
        return results

    def encode(self, heights: ArrayLike, roll: ArrayLike, pitch: ArrayLike) -> NDArray[np.float32]:
        """Input of `run`, (n, planes, 40, 40); arguments as in `answers`."""
        # What is too far away for float32 lies beyond the range of the image all the same.
        with np.errstate(over="ignore"):
            return self.contract.encoding.encode(heights, roll, pitch)


def _unreadable(error: Exception, source: str) -> ModelError:
    """What onnxruntime has against a file, in one line."""
    newer = re.search(r"(Opset \d+|IR version: \d+|domain_version of \d+)", str(error))
    if newer:
        return ModelError(
            f"{source} is written for another onnxruntime than {onnxruntime.__version__} ({newer[1]})",
            "install another onnxruntime, or export the model again",
        )
    first_line = (str(error).strip().splitlines() or [type(error).__name__])[0]
    return ModelError(f"{source} is damaged or no ONNX model ({first_line})", "copy or export it again")


def session_options() -> onnxruntime.SessionOptions:
    """One thread that sleeps when idle: a second gains nothing here, and spinning starves the robot's controller."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    options.execution_mode = onnxruntime.ExecutionMode.ORT_SEQUENTIAL
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_ALL
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    # Failures reach the caller as exceptions; onnxruntime need not print them as well.
    options.log_severity_level = 4
    return options


def _check_shapes(session: onnxruntime.InferenceSession, contract: ModelContract, source: str) -> None:
    """Refuse a graph whose inputs and outputs are not what the contract says, with a free batch axis."""
    cells = [CELLS, CELLS]
    promised = {
        "inputs": {INPUT: [len(contract.encoding.planes), *cells]},
        "outputs": {LOGITS_OUTPUT: [contract.classes, *cells], INFEASIBLE_OUTPUT: cells, COST_OUTPUT: cells},
    }
    for role, ports in (("inputs", session.get_inputs()), ("outputs", session.get_outputs())):
        found = {port.name: list(port.shape) for port in ports}
        free = all(shape and not isinstance(shape[0], int) for shape in found.values())
        floats = all(port.type == "tensor(float)" for port in ports)
        if not (free and floats and {name: shape[1:] for name, shape in found.items()} == promised[role]):
            words = ", ".join(f"{name} [n, {', '.join(map(str, shape))}]" for name, shape in promised[role].items())
            raise ModelError(
                f"{source} has {role} {found} of {sorted({port.type for port in ports})}, "
                f"its contract says float tensors {words}",
                "export the model again",
            )
