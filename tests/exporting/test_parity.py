"""What is counted where two engines answer differently, and engines that answer alike."""

import numpy as np
import onnx
import pytest

from footsel.errors import ModelError
from footsel.exporting.engines import REFERENCE_SHARE, other_engines
from footsel.exporting.parity import TIE, LogitDifferences, Parity
from footsel.exporting.trial_maps import trial_maps
from footsel.runtime import Network


def test_differences_are_counted_by_cells_and_ties():
    """One cell each: within the tolerance; beyond it, the class kept; another class by a tie; another outright."""
    expected = np.zeros((1, 14, 40, 40), dtype=np.float32)
    expected[:, 3] = 1
    expected[0, 5, 0, 2] = 1 - TIE / 2
    found = expected.copy()
    found[0, 7, 0, 0] += 5e-5
    found[0, [3, 7], 0, 1] += 2e-4
    found[0, 5, 0, 2] += TIE
    found[0, 5, 0, 3] = 1.5
    differences = LogitDifferences()
    for _ in range(2):
        differences.update(found, expected)
    assert (differences.maps, differences.cells) == (2, 3200)
    assert differences.max_logit_difference == 1.5
    assert (differences.cells_beyond_tolerance, differences.class_differs) == (6, 4)
    assert differences.class_differs_beyond_ties == 2


def test_batches_change_nothing(anymal_layout, handmade):
    """A check fed in parts says what it says of the whole, and a perfect file is perfect."""
    contract = handmade.contract(anymal_layout)
    content = handmade.random_model(contract, 0)
    network, maps = Network.from_bytes(content, "model"), trial_maps(anymal_layout, "LF", 9, seed=5)
    reports = []
    for size in (2, 9):
        parity = Parity(content, "model", len(maps))
        for batch in maps.batches(size):
            planes = contract.encoding.encode(batch.heights, batch.roll, batch.pitch)
            parity.update(batch, planes, network.logits(batch.heights, batch.roll, batch.pitch))
        parity.require_classes()
        parity.require_decoding()
        reports.append(parity.to_dict(maps.origin))
    assert reports[0]["maps"] == reports[1]["maps"] == 9
    for report in reports:
        assert report["max_logit_difference"] < 1e-5 and report["class_differs_beyond_ties"] == 0
        assert report["feasible_only_exported"] == report["feasible_only_trained"] == 0


def test_every_engine_sees_a_file_that_lies(anymal_layout, handmade):
    """The trained network says class 3 everywhere, the file class 4."""
    maps = trial_maps(anymal_layout, "LF", 2, seed=6)
    contract = handmade.contract(anymal_layout)
    parity = Parity(handmade.constant_model(contract, 4), "front.onnx", len(maps))
    expected = np.zeros((2, 14, 40, 40), dtype=np.float32)
    expected[:, 3] = 8
    parity.update(maps, contract.encoding.encode(maps.heights, maps.roll, maps.pitch), expected)
    for figures in (parity.to_dict(""), *parity.to_dict("")["other_engines"].values()):
        assert figures["class_differs_beyond_ties"] == figures["maps"] * 1600
    with pytest.raises(
        ModelError, match=r"front.onnx says another class than the trained network in 3200 of 3200 cells"
    ):
        parity.require_classes()


def test_the_reference_gets_its_share_of_maps(model_files):
    assert [other_engines(model_files["front.onnx"], maps)[0].maps for maps in (1, 3 * REFERENCE_SHARE)] == [1, 3]


@pytest.mark.parametrize("pair", ["front", "hind"])
def test_engines_answer_alike(released, anymal_layout, pair):
    """A trained network's operators, look-ups of the leg's clearance among them."""
    content = (released.out / f"{pair}.onnx").read_bytes()
    network = Network.from_bytes(content, pair)
    maps = trial_maps(anymal_layout, network.contract.leg, 2, seed=7)
    planes = network.contract.encoding.encode(maps.heights, maps.roll, maps.pitch)
    assert "GatherElements" in {node.op_type for node in onnx.load_from_string(content).graph.node}
    for engine in other_engines(content, len(maps)):
        np.testing.assert_allclose(
            engine.logits(planes), network.logits(maps.heights, maps.roll, maps.pitch), atol=2e-3
        )


def test_one_cell_in_millions_may_be_more_than_a_tie(anymal_layout, handmade):
    """It is counted, and nothing is refused for it; two in a million are."""
    parity = Parity(handmade.constant_model(handmade.contract(anymal_layout)), "front.onnx", 1)
    parity.logits = LogitDifferences(maps=1000, cells=1_600_000, class_differs=1, class_differs_beyond_ties=1)
    parity.require_classes()
    parity.logits.class_differs_beyond_ties = 2
    with pytest.raises(ModelError, match="in 2 of 1600000 cells"):
        parity.require_classes()
