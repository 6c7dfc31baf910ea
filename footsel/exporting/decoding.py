"""The last step inside an exported graph: from logits to what a choice needs, as `footholds.cost` decodes them.

In the graph it costs a runtime one small copy instead of several passes over fourteen planes, and every language that
runs the file decodes alike.
"""

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import numpy_helper, parser

from footsel.footholds.cost import CLASSES, COST_BINS, INFEASIBLE_COST, class_centres
from footsel.runtime.contract import COST_OUTPUT, INFEASIBLE_OUTPUT, LOGITS_OUTPUT
from footsel.terrain import CELLS

#: Likelihoods of any logits are relative to the cell's likeliest class, so none overflows and their sum is 1 or more;
#: those of the feasible classes may all vanish.
_ANY = {
    "likelihoods": f"""
  highest_logit = ReduceMax<keepdims = 1>({LOGITS_OUTPUT}, class_axis)
  relative_logits = Sub({LOGITS_OUTPUT}, highest_logit)
  likelihoods = Exp(relative_logits)""",
    "cost_if_feasible": """
  sum_feasible_safe = Max(sum_feasible, smallest)
  cost_if_feasible = Div(sum_cost, sum_feasible_safe)""",
}
#: Of logits that the network itself keeps within bounds, as FootNet does, two passes over all of them can be saved.
_BOUNDED = {
    "likelihoods": f"likelihoods = Exp({LOGITS_OUTPUT})",
    "cost_if_feasible": "cost_if_feasible = Div(sum_cost, sum_feasible)",
}
#: How far from zero logits may be for that: e to this is far from where float32 ends, up and down, also as a sum.
_BOUND = 60.0

#: One product sums likelihoods in four ways. A mean over three cells along an axis, the border repeated, is a product
#: with a band matrix: onnxruntime is many times faster at it than at pooling a padded plane.
_GRAPH = f"""
<ir_version: 10, opset_import: ["" : 20]>
decoding (float[n, {CLASSES}, {CELLS}, {CELLS}] {LOGITS_OUTPUT})
  => (float[n, {CELLS}, {CELLS}] {INFEASIBLE_OUTPUT}, float[n, {CELLS}, {CELLS}] {COST_OUTPUT})
{{
  %(likelihoods)s
  likelihoods_flat = Reshape(likelihoods, flat_shape)
  sums_flat = MatMul(weights_of_sums, likelihoods_flat)
  sums = Reshape(sums_flat, sums_shape)
  sum_all, sum_feasible, sum_cost, sum_infeasible = Split<axis = 1, num_outputs = 4>(sums)

  infeasible_plane = Div(sum_infeasible, sum_all)
  %(cost_if_feasible)s

  mean_of_columns = MatMul(mean_of_three, infeasible_plane)
  neighbourhood_mean = MatMul(mean_of_columns, mean_of_three_transposed)
  doubt = Max(infeasible_plane, neighbourhood_mean)
  cost_to_infeasible = Sub(infeasible_cost, cost_if_feasible)
  cost_of_doubt = Mul(doubt, cost_to_infeasible)
  cost_plane = Add(cost_if_feasible, cost_of_doubt)

  {INFEASIBLE_OUTPUT} = Squeeze(infeasible_plane, class_axis)
  {COST_OUTPUT} = Squeeze(cost_plane, class_axis)
}}
"""


def with_decoding(network: onnx.ModelProto) -> onnx.ModelProto:
    """A copy of a network maps -> logits whose outputs are `logits`, `infeasible` and `cost`.

    infeasible: (n, 40, 40) probability of the class "infeasible". cost: (n, 40, 40) `expected_cost` of the cells.
    """
    decoding = parser.parse_model(_GRAPH % (_BOUNDED if _is_bounded(network) else _ANY)).graph
    model = onnx.ModelProto()
    model.CopyFrom(network)
    model.graph.node.extend(decoding.node)
    model.graph.output.extend(decoding.output)
    used = {name for node in decoding.node for name in node.input}
    constants = {name: value for name, value in _constants().items() if name in used}
    model.graph.initializer.extend(numpy_helper.from_array(value, name) for name, value in constants.items())
    onnx.checker.check_model(model)
    return model


def without_decoding(model: onnx.ModelProto) -> onnx.ModelProto:
    """A copy of an exported model that ends with its logits; the inverse of `with_decoding`."""
    network = onnx.ModelProto()
    network.CopyFrom(model)
    graph = network.graph
    needed = {LOGITS_OUTPUT}
    nodes: list[onnx.NodeProto] = []
    for node in reversed(graph.node):
        if needed.intersection(node.output):
            needed.update(node.input)
            nodes.insert(0, node)
    for field, kept in (
        (graph.node, nodes),
        (graph.initializer, [tensor for tensor in graph.initializer if tensor.name in needed]),
        (graph.output, [output for output in graph.output if output.name == LOGITS_OUTPUT]),
    ):
        copies = [type(part).FromString(part.SerializeToString()) for part in kept]
        del field[:]
        field.extend(copies)
    return network


def _is_bounded(network: onnx.ModelProto) -> bool:
    """Whether the network's last step clips its logits to no more than _BOUND."""
    graph = network.graph
    last = next((node for node in graph.node if LOGITS_OUTPUT in node.output), None)
    if last is None or last.op_type != "Clip":
        return False
    values = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
    bounds = [values[name] for name in last.input[1:] if name in values]
    return len(bounds) == 2 and bool(np.abs(bounds).max() <= _BOUND)


def _constants() -> dict[str, NDArray[np.generic]]:
    classes = np.arange(CLASSES)
    feasible = classes < COST_BINS
    costs = np.append(class_centres(), np.float32(0))
    band = np.eye(CELLS, k=-1) + np.eye(CELLS) + np.eye(CELLS, k=1)
    # The border stands in for the cell beyond it.
    band[0, 0] = band[-1, -1] = 2
    mean_of_three = np.asarray(band / 3, dtype=np.float32)
    return {
        "class_axis": np.array([1], dtype=np.int64),
        "flat_shape": np.array([0, CLASSES, CELLS * CELLS], dtype=np.int64),
        "weights_of_sums": np.array([classes >= 0, feasible, costs, ~feasible], dtype=np.float32),
        "sums_shape": np.array([0, 4, CELLS, CELLS], dtype=np.int64),
        "smallest": np.array(np.finfo(np.float32).tiny),
        "mean_of_three": mean_of_three,
        "mean_of_three_transposed": np.ascontiguousarray(mean_of_three.T),
        "infeasible_cost": np.array(INFEASIBLE_COST, dtype=np.float32),
    }
