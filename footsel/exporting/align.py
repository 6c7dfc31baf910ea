"""Input channels of convolutions in multiples of four: only those onnxruntime computes in its blocked layout."""

import numpy as np
import onnx
from onnx import numpy_helper, shape_inference

#: What onnxruntime's NCHWc transformer asks of the input channels of a convolution that has more than a block of them.
MULTIPLE, BLOCK = 4, 16


def aligned(model: onnx.ModelProto) -> onnx.ModelProto:
    """The same function: where planes are laid side by side for a convolution, some come twice, with weights of zero.

    A convolution that nothing fits stays as it is.
    """
    found = onnx.ModelProto()
    found.CopyFrom(model)
    graph = found.graph
    made_by = {output: node for node in graph.node for output in node.output}
    constants = {constant.name: constant for constant in graph.initializer}
    channels = _channels(model)
    for convolution in [node for node in graph.node if node.op_type == "Conv" and node.input[1] in constants]:
        kernels = numpy_helper.to_array(constants[convolution.input[1]])
        missing = -kernels.shape[1] % MULTIPLE
        reshape = made_by.get(convolution.input[0])
        if not missing or kernels.shape[1] <= BLOCK or reshape is None or reshape.op_type != "Reshape":
            continue
        concat = made_by.get(reshape.input[0])
        if concat is None or concat.op_type != "Concat":
            continue
        again = next((name for name in concat.input if channels.get(name) == missing), None)
        if again is None or len(_readers(graph, concat.output[0])) > 1 or len(_readers(graph, reshape.output[0])) > 1:
            continue
        concat.input.append(again)
        shape = numpy_helper.to_array(constants[reshape.input[1]]).copy()
        shape[1] += missing
        zeros = np.zeros((kernels.shape[0], missing, *kernels.shape[2:]), dtype=kernels.dtype)
        wider = np.concatenate([kernels, zeros], axis=1)
        # Names of their own, for a constant may serve several nodes.
        for node, place, values in ((reshape, 1, shape), (convolution, 1, wider)):
            node.input[place] = f"{convolution.name}_{node.op_type.lower()}"
            graph.initializer.append(numpy_helper.from_array(values, node.input[place]))
    _drop_unused(graph)
    # Shapes noted by the exporter may be others now.
    del graph.value_info[:]
    onnx.checker.check_model(found, full_check=True)
    return found


def _channels(model: onnx.ModelProto) -> dict[str, int]:
    """Second dimension of every tensor for which it is known."""
    inferred = shape_inference.infer_shapes(model).graph
    shapes = {value.name: value.type.tensor_type.shape.dim for value in (*inferred.input, *inferred.value_info)}
    return {name: dims[1].dim_value for name, dims in shapes.items() if len(dims) > 1 and dims[1].dim_value}


def _readers(graph: onnx.GraphProto, tensor: str) -> list[onnx.NodeProto]:
    return [node for node in graph.node if tensor in node.input]


def _drop_unused(graph: onnx.GraphProto) -> None:
    used = {name for node in graph.node for name in node.input}
    kept = [constant for constant in graph.initializer if constant.name in used]
    del graph.initializer[:]
    graph.initializer.extend(kept)
