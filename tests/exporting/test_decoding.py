"""The decoding inside a graph against footholds.cost, for any logits."""

import numpy as np
import onnx
import onnxruntime
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import TensorProto, helper, numpy_helper

from footsel.exporting.decoding import with_decoding, without_decoding
from footsel.footholds.cost import INFEASIBLE_CLASS, expected_cost, softmax
from footsel.legs import PAIRS
from footsel.runtime.model_folder import find_model_folder, network_file


def identity() -> onnx.ModelProto:
    """logits = maps."""
    ports = [helper.make_tensor_value_info(name, TensorProto.FLOAT, ["n", 14, 40, 40]) for name in ("maps", "logits")]
    graph = helper.make_graph([helper.make_node("Identity", ["maps"], ["logits"])], "test", ports[:1], ports[1:])
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 20)], ir_version=10)


def clipped(largest: float) -> onnx.ModelProto:
    """logits = maps, at most so far from zero."""
    model = identity()
    bounds = {"least": -largest, "most": largest}
    model.graph.initializer.extend(numpy_helper.from_array(np.float32(value), name) for name, value in bounds.items())
    model.graph.node[0].CopyFrom(helper.make_node("Clip", ["maps", *bounds], ["logits"]))
    return model


def decoding_of(network: onnx.ModelProto):
    session = onnxruntime.InferenceSession(with_decoding(network).SerializeToString())
    assert [output.name for output in session.get_outputs()] == ["logits", "infeasible", "cost"]
    return lambda logits: session.run(["infeasible", "cost"], {"maps": logits})


@pytest.fixture(scope="module")
def decode():
    return decoding_of(identity())


def check(decode, logits):
    infeasible, cost = decode(logits)
    probabilities = softmax(logits, axis=1)
    np.testing.assert_allclose(infeasible, probabilities[:, INFEASIBLE_CLASS], atol=1e-6)
    np.testing.assert_allclose(cost, expected_cost(probabilities), atol=2e-4)


@settings(deadline=None, max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    maps=st.integers(1, 3),
    spread=st.sampled_from([0.0, 1e-3, 1.0, 10.0, 100.0, 1e4, 1e30]),
    offset=st.sampled_from([0.0, -1e3, 1e3, 1e6]),
    lift=st.sampled_from([0.0, 200.0, -200.0]),
)
def test_any_logits_are_decoded_as_in_numpy(decode, seed, maps, spread, offset, lift):
    logits = np.random.default_rng(seed).normal(0, 1, (maps, 14, 40, 40)) * spread + offset
    logits[:, INFEASIBLE_CLASS] += lift
    check(decode, logits.astype(np.float32))


def test_a_cell_that_is_surely_infeasible_costs_255_and_not_nan(decode):
    logits = np.full((1, 14, 40, 40), -3e38, dtype=np.float32)
    logits[:, INFEASIBLE_CLASS] = 3e38
    infeasible, cost = decode(logits)
    assert (infeasible == 1).all() and (cost == 255).all()


def test_doubt_spreads_to_the_neighbours_and_stops_at_the_border(decode):
    """One infeasible cell in the corner: the cell itself stands in for those beyond it, four times in nine."""
    logits = np.zeros((1, 14, 40, 40), dtype=np.float32)
    logits[:, 1:] = -200
    logits[:, :, 0, 0] = np.where(np.arange(14) == INFEASIBLE_CLASS, 0, -200)
    cost = decode(logits)[1][0]
    cheapest = 255 / 26
    assert cost[0, 0] == 255
    assert cost[0, 1] == cost[1, 0] == pytest.approx(cheapest + 2 / 9 * (255 - cheapest), abs=1e-3)
    assert cost[1, 1] == pytest.approx(cheapest + 1 / 9 * (255 - cheapest), abs=1e-3)
    np.testing.assert_allclose(cost[2:], cheapest, atol=1e-3)


@pytest.mark.parametrize("largest", [12.0, 60.0, 61.0, 1e30])
@pytest.mark.parametrize("which", [0, INFEASIBLE_CLASS])
def test_logits_within_bounds_are_decoded_alike(largest, which):
    """Also where all but one class are as unlikely as they can be."""
    logits = np.random.default_rng(0).uniform(-1, 1, (2, 14, 40, 40)) * min(1.2 * largest, 3e38)
    logits[1] = -largest
    logits[1, which] = largest
    logits = logits.astype(np.float32)
    infeasible, cost = decoding_of(clipped(largest))(logits)
    probabilities = softmax(logits.clip(-largest, largest), axis=1)
    np.testing.assert_allclose(infeasible, probabilities[:, INFEASIBLE_CLASS], atol=1e-6)
    np.testing.assert_allclose(cost, expected_cost(probabilities), atol=2e-4)


def test_bounds_save_passes_over_the_logits():
    """FootNet's bounds do; a network without any, or with wide ones, needs the largest logit of every cell."""
    saved = [len(with_decoding(network).graph.node) for network in (clipped(12.0), clipped(1e3), identity())]
    assert saved[0] < saved[1] == saved[2]


@pytest.mark.parametrize(("name", "bounded"), [("anymal_b", True), ("anymal_b_paper", False)])
@pytest.mark.parametrize("pair", PAIRS)
def test_what_is_released_takes_no_pass_that_it_can_save(name, bounded, pair):
    """A clip that an exporter writes in another way would only be slower, and nothing else would tell."""
    model = onnx.load(find_model_folder(name) / network_file(pair))
    assert ("highest_logit" in {output for node in model.graph.node for output in node.output}) != bounded


@pytest.mark.parametrize("network", [identity(), clipped(12.0)], ids=["any", "bounded"])
def test_decoding_can_be_taken_off_again(network):
    assert without_decoding(with_decoding(network)) == network
    assert without_decoding(network) == network
