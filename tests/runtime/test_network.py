"""One ONNX file: what is refused, and that the contract it carries is the one that was written."""

import json

import numpy as np
import pytest

from footsel.errors import InputError, ModelError
from footsel.footholds.encoding import InputEncoding
from footsel.runtime import ModelContract, Network
from footsel.runtime.contract import METADATA_KEY


def test_the_contract_survives_the_file(handmade, anymal_layout):
    written = handmade.contract(anymal_layout, "hind")
    read = Network.from_bytes(handmade.random_model(written, 0), "hind.onnx").contract
    assert read.to_json() == written.to_json()


@pytest.mark.parametrize(
    "change",
    [
        {"classes": 13},
        {"feasible_below": 0.0},
        {"feasible_below": float("nan")},
        {"distance_weight": -1.0},
        {"pair": "middle"},
        {"leg": "RF"},
        {"leg": "LH"},
        {"frame": "the world"},
    ],
)
def test_a_contract_out_of_range_is_refused(handmade, anymal_layout, change):
    with pytest.raises(InputError):
        handmade.contract(anymal_layout, **change)


def test_probabilities_are_those_of_the_filter(handmade, anymal_layout):
    """Against a convolution written out in numpy, roll and pitch planes included."""
    rng = np.random.default_rng(0)
    weight, bias = rng.normal(0, 1, (14, 4, 1, 1)), rng.normal(0, 1, 14)
    contract = handmade.contract(anymal_layout)
    model = handmade.convolution_model(weight, bias, {METADATA_KEY: contract.to_json()})
    heights = rng.uniform(-0.8, 0, (3, 40, 40)).astype(np.float32)
    heights[rng.random(heights.shape) < 0.1] = np.nan
    roll, pitch = np.array([0.1, 0.0, -0.1]), 0.05
    planes = contract.encoding.encode(heights, roll, pitch)
    logits = np.einsum("oc,ncij->noij", weight[:, :, 0, 0], planes) + bias[:, None, None]
    expected = np.exp(logits) / np.exp(logits).sum(axis=1, keepdims=True)
    found = Network.from_bytes(model, "front.onnx").probabilities(heights, roll, pitch)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, expected, atol=2e-6)


def test_a_batch_is_its_maps_one_by_one(handmade, anymal_layout):
    network = Network.from_bytes(handmade.random_model(handmade.contract(anymal_layout), 1), "front.onnx")
    heights = np.random.default_rng(1).uniform(-0.8, 0, (5, 40, 40))
    together = network.probabilities(heights, np.linspace(-0.1, 0.1, 5))
    for index, roll in enumerate(np.linspace(-0.1, 0.1, 5)):
        np.testing.assert_allclose(
            network.probabilities(heights[index : index + 1], roll)[0], together[index], atol=1e-6
        )


def _with_metadata(handmade, layout, change):
    values = json.loads(handmade.contract(layout).to_json())
    change(values)
    return {METADATA_KEY: json.dumps(values)}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda values: values.update(schema=99), "schema 99"),
        (lambda values: values.pop("layout"), "damaged footsel contract"),
        (lambda values: values["layout"]["hips"].pop("RH"), "damaged footsel contract"),
        (lambda values: values["encoding"].update(planes=["colour"]), "damaged footsel contract"),
        (lambda values: values.update(pair="middle"), "damaged footsel contract"),
        (lambda values: values.update(feasible_below=7), "damaged footsel contract"),
        (lambda values: values.update(schema=1), "schema 1, this footsel reads 2; export the model again"),
        (lambda values: values.update(leg="RF"), "the trained leg is 'RF'"),
        (lambda values: values.pop("frame"), "damaged footsel contract"),
        (lambda values: values.update(frame="world"), "the frame is 'world'"),
        (lambda values: values.update(opset="new"), "damaged footsel contract"),
        (lambda values: values.pop("commit"), "damaged footsel contract"),
        (lambda values: values["encoding"].update(planes=["height"]), "its contract says"),
    ],
)
def test_a_contract_that_does_not_hold_is_refused(handmade, anymal_layout, change, words):
    metadata = _with_metadata(handmade, anymal_layout, change)
    model = handmade.convolution_model(np.zeros((14, 4, 1, 1)), np.zeros(14), metadata)
    with pytest.raises(ModelError, match=words):
        Network.from_bytes(model, "front.onnx")


@pytest.mark.parametrize("text", ["", "[]", "7", "no json", '"text"'])
def test_metadata_that_is_no_contract_is_refused(handmade, text):
    model = handmade.convolution_model(np.zeros((14, 4, 1, 1)), np.zeros(14), {METADATA_KEY: text})
    with pytest.raises(ModelError, match="damaged footsel contract"):
        Network.from_bytes(model, "front.onnx")


def test_a_foreign_onnx_file_is_refused(handmade):
    model = handmade.convolution_model(np.zeros((14, 4, 1, 1)), np.zeros(14), {})
    with pytest.raises(ModelError, match=r"front.onnx carries no footsel contract; use a model written by"):
        Network.from_bytes(model, "front.onnx")


@pytest.mark.parametrize(("outputs", "cells"), [(13, 40), (14, 32)])
def test_another_shape_than_the_contract_says_is_refused(handmade, anymal_layout, outputs, cells):
    metadata = {METADATA_KEY: handmade.contract(anymal_layout).to_json()}
    model = handmade.convolution_model(np.zeros((outputs, 4, 1, 1)), np.zeros(outputs), metadata, cells)
    with pytest.raises(ModelError, match="its contract says"):
        Network.from_bytes(model, "front.onnx")


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_one_clear_line(handmade, anymal_layout, tmp_path, share, capfd):
    content = handmade.random_model(handmade.contract(anymal_layout), 0)
    path = tmp_path / "front.onnx"
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(ModelError) as caught:
        Network.load(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr().err == ""


def test_a_missing_file_and_a_text_file_are_refused(tmp_path):
    with pytest.raises(ModelError, match="cannot read model"):
        Network.load(tmp_path / "absent.onnx")
    (tmp_path / "text.onnx").write_text("this is no model")
    with pytest.raises(ModelError, match="no ONNX model"):
        Network.load(tmp_path / "text.onnx")


def test_to_json_names_every_field(handmade, anymal_layout):
    values = json.loads(handmade.contract(anymal_layout, encoding=InputEncoding()).to_json())
    assert set(values) == set(ModelContract.__dataclass_fields__) | {"schema"}
