"""Fixtures of several rooms: a leg layout, small ONNX models whose every output is known, the scripts of docs/."""

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from footsel.exporting.decoding import with_decoding
from footsel.footholds import LegLayout
from footsel.footholds.encoding import InputEncoding
from footsel.runtime.contract import FRAME, METADATA_KEY, ModelContract
from footsel.runtime.model_folder import SUMS_FILE, sums_text

DOCS = Path(__file__).resolve().parents[1] / "docs"
PLANES = ("height", "unknown", "roll", "pitch")


def contract(layout: LegLayout, pair: str = "front", **changes: object) -> ModelContract:
    values = {
        "robot": "anymal_b",
        "pair": pair,
        "leg": {"front": "LF", "hind": "LH"}.get(pair, ""),
        "frame": FRAME,
        "layout": layout,
        "encoding": InputEncoding(PLANES, quantised=False, height_range=0.85),
        "classes": 14,
        "feasible_below": 0.2,
        "distance_weight": 160.0,
        "recipe": "test",
        "dataset_sha256": "0" * 64,
        "version": "0",
        "opset": 20,
        "commit": "0" * 40,
    }
    return ModelContract(**{**values, **changes})


def convolution_model(weight: np.ndarray, bias: np.ndarray, metadata: dict[str, str], cells: int = 40) -> bytes:
    """logits = weight * maps + bias, same size, and their decoding where it can be."""
    outputs, inputs, kernel, _ = weight.shape
    node = helper.make_node("Conv", ["maps", "w", "b"], ["logits"], pads=[kernel // 2] * 4)
    graph = helper.make_graph(
        [node],
        "test",
        [helper.make_tensor_value_info("maps", TensorProto.FLOAT, ["n", inputs, cells, cells])],
        [helper.make_tensor_value_info("logits", TensorProto.FLOAT, ["n", outputs, cells, cells])],
        [
            numpy_helper.from_array(weight.astype(np.float32), "w"),
            numpy_helper.from_array(bias.astype(np.float32), "b"),
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 20)], ir_version=10)
    if (outputs, cells) == (14, 40):
        model = with_decoding(model)
    for key, value in metadata.items():
        model.metadata_props.add(key=key, value=value)
    onnx.checker.check_model(model)
    return model.SerializeToString()


def constant_model(contract: ModelContract, class_: int = 0) -> bytes:
    """The same class for every cell, whatever the map."""
    bias = np.where(np.arange(14) == class_, 8.0, 0.0)
    return convolution_model(np.zeros((14, 4, 1, 1)), bias, {METADATA_KEY: contract.to_json()})


def random_model(contract: ModelContract, seed: int) -> bytes:
    """A random 5x5 filter: every output depends on its neighbourhood, on left and right, and on the tilt."""
    rng = np.random.default_rng(seed)
    weight, bias = rng.normal(0, 1.0, (14, 4, 5, 5)), rng.normal(0, 1, 14)
    return convolution_model(weight, bias, {METADATA_KEY: contract.to_json()})


def write_folder(folder: Path, files: dict[str, bytes]) -> Path:
    papers = {"model_card.md": b"# card\n", "metrics.json": b"{}\n", "parity.json": b"{}\n"}
    contents = {**papers, **files}
    contents[SUMS_FILE] = sums_text(contents).encode()
    folder.mkdir(parents=True)
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    return folder


@pytest.fixture(scope="session")
def anymal_layout() -> LegLayout:
    """Legs where ANYmal B has them, to the centimetre, for tests that need no robot model."""
    sides = {"LF": (1, 1), "RF": (1, -1), "LH": (-1, 1), "RH": (-1, -1)}
    return LegLayout(
        hips={leg: np.array([0.34 * x, 0.246 * y, 0.0]) for leg, (x, y) in sides.items()},
        nominal_feet={leg: np.array([0.36 * x, 0.246 * y, -0.47]) for leg, (x, y) in sides.items()},
        resolution=0.02,
        height_range=0.85,
        foot_radius=0.031,
    )


@pytest.fixture(scope="session")
def handmade() -> SimpleNamespace:
    """The makers above, for tests."""
    return SimpleNamespace(
        constant_model=constant_model,
        contract=contract,
        convolution_model=convolution_model,
        random_model=random_model,
        write_folder=write_folder,
    )


@pytest.fixture
def model_files(anymal_layout: LegLayout) -> dict[str, bytes]:
    """A front and a hind network with random filters."""
    return {
        f"{pair}.onnx": random_model(contract(anymal_layout, pair), seed) for seed, pair in enumerate(("front", "hind"))
    }


@pytest.fixture
def model_folder(tmp_path: Path, model_files: dict[str, bytes]) -> Path:
    return write_folder(tmp_path / "model", model_files)


@pytest.fixture
def constant_folder(tmp_path: Path, anymal_layout: LegLayout) -> Callable[[int], Path]:
    """class -> folder of networks that say this class everywhere."""

    def make(class_: int) -> Path:
        models = {pair: constant_model(contract(anymal_layout, pair), class_) for pair in ("front", "hind")}
        files = {f"{pair}{end}": model for pair, model in models.items() for end in (".onnx", ".int8.onnx")}
        return write_folder(tmp_path / f"constant{class_}", files)

    return make


@pytest.fixture
def script() -> Callable[[str], ModuleType]:
    """script("update_tables"): a fresh module of docs/, which is no package."""

    def load(name: str) -> ModuleType:
        spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    return load
