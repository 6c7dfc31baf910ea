"""Static 8-bit quantisation of an exported network (QDQ, unsigned activations, signed weights per channel)."""

import tempfile
from collections.abc import Collection, Iterator
from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray
from onnxruntime.quantization import (
    CalibrationDataReader,
    CalibrationMethod,
    QuantFormat,
    QuantType,
    quantize_static,
)
from onnxruntime.quantization.shape_inference import quant_pre_process

from footsel.exporting.onnx_file import strip

_BATCH = 20
#: Share of the activations that the range of a plane covers, in percent. What lies beyond is of cells clearly out
#: of reach; with it in the range, 8 % of all cells change between feasible and not, without it half a percent.
_COVERED = 99.9


class _Batches(CalibrationDataReader):  # type: ignore[misc]
    """Calibration inputs, a batch at a time."""

    def __init__(self, name: str, planes: NDArray[np.float32]) -> None:
        self._batches: Iterator[dict[str, NDArray[np.float32]]] = (
            {name: planes[start : start + _BATCH]} for start in range(0, len(planes), _BATCH)
        )

    def get_next(self) -> dict[str, NDArray[np.float32]] | None:
        """The next batch, None after the last."""
        return next(self._batches, None)


def quantised(model: onnx.ModelProto, planes: NDArray[np.float32], exact: Collection[str] = ()) -> onnx.ModelProto:
    """The model in 8 bits, its activation ranges taken from running `planes` (n, in_channels, 40, 40) through it.

    exact: names of parts of the network that stay in float32, with all that they depend on. So does the layer that
        makes the logits: it is small, and nothing evens out what it rounds.
    """
    with tempfile.TemporaryDirectory() as folder:
        source, prepared, target = (Path(folder) / name for name in ("source.onnx", "prepared.onnx", "target.onnx"))
        onnx.save(model, source)
        # The plain shape inference knows all that is needed; the symbolic one stumbles over slices.
        quant_pre_process(str(source), str(prepared), skip_symbolic_shape=True)
        quantize_static(
            str(prepared),
            str(target),
            _Batches(model.graph.input[0].name, planes),
            quant_format=QuantFormat.QDQ,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
            per_channel=True,
            calibrate_method=CalibrationMethod.Percentile,
            extra_options={"CalibPercentile": _COVERED},
            nodes_to_exclude=_excluded(onnx.load(prepared), exact),
        )
        result = onnx.load(target)
    strip(result)
    return result


def _excluded(model: onnx.ModelProto, exact: Collection[str]) -> list[str]:
    """Names of the nodes of the exact parts, and of the last layer."""
    layers = [node.name for node in model.graph.node if node.op_type in ("Conv", "ConvTranspose")]
    return [*_nodes_of(model, exact), *layers[-1:]]


def _nodes_of(model: onnx.ModelProto, parts: Collection[str]) -> list[str]:
    """Names of the nodes that use a weight of one of `parts`, and of all nodes before them."""
    before: set[str] = set()
    names = []
    for node in reversed(model.graph.node):
        if before.intersection(node.output) or any(name.split(".")[0] in parts for name in node.input):
            before.update(node.input)
            names.append(node.name)
    return names
