"""Some planes come twice and count once: the same answers, in channels that onnxruntime's blocked layout takes."""

import numpy as np
import onnx
import onnxruntime
import pytest
from onnx import TensorProto, helper, numpy_helper

from footsel.exporting.align import BLOCK, MULTIPLE, aligned


def planes_side_by_side(widths, seed=0):
    """Inputs x0, x1 ... of these channels (n, c, 100) laid side by side, a 1x1 convolution, and its sum read twice."""
    rng = np.random.default_rng(seed)
    total = sum(widths)
    names = [f"x{index}" for index in range(len(widths))]
    constants = [
        numpy_helper.from_array(np.array([-1, total, 10, 10]), "shape"),
        numpy_helper.from_array(rng.normal(size=(8, total, 1, 1)).astype(np.float32), "kernels"),
    ]
    nodes = [
        helper.make_node("Concat", names, ["side"], axis=1, name="concat"),
        helper.make_node("Reshape", ["side", "shape"], ["image"], name="reshape"),
        helper.make_node("Conv", ["image", "kernels"], ["out"], name="conv"),
    ]
    inputs = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n", width, 100])
        for name, width in zip(names, widths, strict=True)
    ]
    output = helper.make_tensor_value_info("out", TensorProto.FLOAT, ["n", 8, 10, 10])
    graph = helper.make_graph(nodes, "planes", inputs, [output], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 20)], ir_version=10)
    onnx.checker.check_model(model, full_check=True)
    return model


def answers(model, widths):
    session = onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    rng = np.random.default_rng(1)
    maps = {f"x{index}": rng.normal(size=(3, width, 100)).astype(np.float32) for index, width in enumerate(widths)}
    return session.run(None, maps)[0]


def kernels(model):
    (convolution,) = (node for node in model.graph.node if node.op_type == "Conv")
    return next(numpy_helper.to_array(c) for c in model.graph.initializer if c.name == convolution.input[1])


@pytest.mark.parametrize("widths", [(20, 3, 6), (3, 14), (1, 2, 20)])
def test_planes_that_come_twice_count_once(widths):
    model = planes_side_by_side(widths)
    found = aligned(model)
    assert kernels(found).shape[1] % MULTIPLE == 0 < kernels(found).shape[1] - sum(widths) < MULTIPLE
    np.testing.assert_allclose(answers(found, widths), answers(model, widths), rtol=1e-5, atol=1e-5)
    assert len(found.graph.initializer) == len(model.graph.initializer)
    # And then there is nothing more to do.
    assert aligned(found).SerializeToString(deterministic=True) == found.SerializeToString(deterministic=True)


@pytest.mark.parametrize("widths", [(20, 4, 8), (20, 5, 6), (3, 2)])
def test_what_is_aligned_does_not_fit_or_is_small_stays(widths):
    assert sum(widths) % MULTIPLE == 0 or 3 not in widths or sum(widths) <= BLOCK
    assert kernels(aligned(planes_side_by_side(widths))).shape[1] == sum(widths)


def test_the_released_networks_are_aligned(released):
    """All but convolutions so small that onnxruntime takes their input as it is."""
    for pair in ("front", "hind"):
        model = onnx.load(released.out / f"{pair}.onnx")
        constants = {constant.name: constant for constant in model.graph.initializer}
        for node in model.graph.node:
            if node.op_type == "Conv":
                inputs = constants[node.input[1]].dims[1]
                assert inputs <= BLOCK or inputs % MULTIPLE == 0
