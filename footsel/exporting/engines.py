"""Engines other than onnxruntime that run an exported file: what it says is not one engine's reading of it."""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnx.reference import ReferenceEvaluator
from onnx.reference.op_run import OpRun
from torch import nn

from footsel.runtime.contract import INPUT, LOGITS_OUTPUT

try:
    import openvino
except ModuleNotFoundError:
    openvino = None

#: Encoded maps (n, planes, 40, 40) -> (n, 14, 40, 40) logits.
Logits = Callable[[NDArray[np.float32]], NDArray[np.float32]]

#: The reference evaluator takes over a hundred times as long per map as the others, torch in float64 a few times as
#: long: they get one map of so many.
REFERENCE_SHARE, DOUBLE_SHARE = 200, 10


@dataclass(frozen=True)
class Engine:
    """name: with its version. logits: what it answers. maps: that it is asked for at most, None for all."""

    name: str
    logits: Logits
    maps: int | None = None


def other_engines(content: bytes, maps: int) -> list[Engine]:
    """onnx's reference evaluator, and OpenVINO where it is installed, with a file that `maps` are tried on."""
    few = max(maps // REFERENCE_SHARE, 1)
    engines = [Engine(f"onnx reference {onnx.__version__}", _reference(content), few)]
    if openvino is not None:
        engines.append(Engine(f"openvino {openvino.__version__.split('-')[0]}", _openvino(content)))
    return engines


def double_precision(trained: nn.Module, maps: int) -> Engine:
    """The trained network in float64: as far from it as float32 is from exact, no other engine can come nearer."""
    network = copy.deepcopy(trained).double()

    def run(planes: NDArray[np.float32]) -> NDArray[np.float32]:
        with torch.inference_mode():
            return np.asarray(network(torch.from_numpy(planes).double()).float().numpy())

    return Engine(f"torch {torch.__version__.split('+')[0]} in float64", run, max(maps // DOUBLE_SHARE, 1))


class GatherElements(OpRun):
    """The operator as onnx defines it; its own evaluator fails where an axis is longer than 64."""

    op_domain = ""

    def _run(self, data: NDArray[Any], indices: NDArray[Any], axis: int = 0) -> tuple[NDArray[Any]]:
        return (np.take_along_axis(data, indices, axis),)


def _reference(content: bytes) -> Logits:
    session = ReferenceEvaluator(onnx.load_from_string(content), new_ops=[GatherElements])

    def run(planes: NDArray[np.float32]) -> NDArray[np.float32]:
        (logits,) = session.run([LOGITS_OUTPUT], {INPUT: planes})
        return np.asarray(logits)

    return run


def _openvino(content: bytes) -> Logits:
    # On some processors it would compute in 16 bits if it might.
    options: dict[str, Any] = {"INFERENCE_PRECISION_HINT": "f32", "INFERENCE_NUM_THREADS": 1}
    core = openvino.Core()
    compiled = core.compile_model(core.read_model(content), "CPU", options)
    return lambda planes: np.asarray(compiled({INPUT: planes})[LOGITS_OUTPUT])
