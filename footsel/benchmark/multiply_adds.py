"""The multiply-adds of a network for one local map, counted from its graph."""

import math
from pathlib import Path
from typing import Any

from footsel.errors import MissingExtraError


def multiply_adds(path: Path) -> int:
    """Of all convolutions and matrix products of an exported file, for a batch of one.

    Raises MissingExtraError where onnx is not installed.
    """
    try:
        import onnx
    except ModuleNotFoundError as error:
        raise MissingExtraError("counting a network's multiply-adds", "train", error.name or "onnx") from None

    model = onnx.load(path)
    for port in (*model.graph.input, *model.graph.output):
        port.type.tensor_type.shape.dim[0].dim_value = 1
    del model.graph.value_info[:]
    graph = onnx.shape_inference.infer_shapes(model, data_prop=True).graph
    shapes = {tensor.name: tuple(tensor.dims) for tensor in graph.initializer}
    for value in (*graph.value_info, *graph.input, *graph.output):
        shapes[value.name] = tuple(dim.dim_value for dim in value.type.tensor_type.shape.dim)
    return sum(_of_node(node, shapes) for node in graph.node)


def _of_node(node: Any, shapes: dict[str, tuple[int, ...]]) -> int:
    if node.op_type == "Conv":
        # Each output cell meets every weight of its channel: (outputs, inputs / groups, height, width).
        return math.prod(shapes[node.output[0]]) * math.prod(shapes[node.input[1]][1:])
    if node.op_type == "ConvTranspose":
        # Each input cell goes into every weight of its channel: (inputs, outputs / groups, height, width).
        return math.prod(shapes[node.input[0]]) * math.prod(shapes[node.input[1]][1:])
    if node.op_type in ("MatMul", "Gemm"):
        inner = shapes[node.input[0]][-1]
        return math.prod(shapes[node.output[0]]) * inner
    return 0
