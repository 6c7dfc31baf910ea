"""A torch network as an ONNX model that carries its contract and nothing of the machine that wrote it."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import onnx
import torch
from torch import nn

from footsel.runtime.contract import INPUT, LOGITS_OUTPUT, METADATA_KEY, ModelContract
from footsel.terrain import CELLS

#: The newest operator set that every supported onnxruntime (1.18 and later) runs.
OPSET = 20


def to_onnx(network: nn.Module, in_channels: int) -> onnx.ModelProto:
    """The network as one self-contained graph: maps (n, in_channels, 40, 40) -> logits, any n."""
    # Torch specialises a graph for an example batch of one.
    example = torch.zeros(2, in_channels, CELLS, CELLS)
    with _quiet_exporter():
        program = torch.onnx.export(
            network,
            (example,),
            dynamo=True,
            external_data=False,
            opset_version=OPSET,
            input_names=[INPUT],
            output_names=[LOGITS_OUTPUT],
            dynamic_shapes=({0: torch.export.Dim("n")},),
            verbose=False,
        )
    if program is None:
        raise RuntimeError("torch.onnx.export returned nothing")
    model = program.model_proto
    strip(model)
    onnx.checker.check_model(model)
    return model


def strip(model: onnx.ModelProto) -> None:
    """Remove, in place, all notes that the exporter left: stack traces with local paths, module names, statistics."""
    del model.metadata_props[:]
    model.doc_string = ""
    graph = model.graph
    graph.doc_string = ""
    for part in (graph, *graph.node, *graph.value_info, *graph.input, *graph.output, *graph.initializer):
        del part.metadata_props[:]
        part.doc_string = ""


def with_contract(model: onnx.ModelProto, contract: ModelContract) -> bytes:
    """The content of a released file: the model with the contract in its metadata."""
    released = onnx.ModelProto()
    released.CopyFrom(model)
    strip(released)
    released.metadata_props.add(key=METADATA_KEY, value=contract.to_json())
    return bytes(released.SerializeToString(deterministic=True))


@contextmanager
def _quiet_exporter() -> Iterator[None]:
    """Hide the exporter's remarks on packages that this network does not use; errors still come through."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)
            yield
    finally:
        logger.setLevel(level)
