"""From a run to a model folder that the runtime loads and that answers as the trained network."""

import hashlib
import json
import re
import shutil
import subprocess
import sys

import numpy as np
import onnx
import pytest
import torch

from footsel import ElevationMap
from footsel.errors import InputError, ModelError
from footsel.exporting import export_run as module
from footsel.exporting import sources
from footsel.exporting.decoding import without_decoding
from footsel.exporting.export_run import export_run
from footsel.exporting.model_card import model_card
from footsel.exporting.parity import TIE, graph_logits
from footsel.exporting.provenance import source_commit
from footsel.exporting.trial_maps import trial_maps
from footsel.footholds import DISTANCE_WEIGHT
from footsel.learning.checkpoint import read_model
from footsel.learning.learner import Learner
from footsel.learning.recipe import Recipe
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.warm_start import start_from
from footsel.legs import PAIRS, TRAINED_LEG
from footsel.runtime import FootholdSelector, Network
from footsel.terrain.courses import make_course

FILES = {"front.onnx", "hind.onnx", "front.int8.onnx", "hind.int8.onnx"}
WEIGHTS = {"front.safetensors", "hind.safetensors"}
PAPERS = {"model_card.md", "metrics.json", "parity.json", *WEIGHTS}


def test_the_folder_holds_what_a_release_holds(released):
    assert {path.name for path in released.out.iterdir()} == FILES | PAPERS | {"SHA256SUMS"}
    sums = dict(reversed(line.split("  ")) for line in (released.out / "SHA256SUMS").read_text().splitlines())
    assert set(sums) == FILES | PAPERS
    for name, digest in sums.items():
        assert hashlib.sha256((released.out / name).read_bytes()).hexdigest() == digest


@pytest.mark.parametrize("pair", PAIRS)
def test_torch_and_onnxruntime_agree_on_500_maps(released, anymal_layout, pair):
    """Other maps than those of the export's own check, holes and borders among them."""
    maps = trial_maps(anymal_layout, TRAINED_LEG[pair], 500, seed=123)
    assert 0.02 < np.isnan(maps.heights).mean() < 0.5
    exported = Network.load(released.out / f"{pair}.onnx")
    planes = exported.contract.encoding.encode(maps.heights, maps.roll, maps.pitch)
    with torch.no_grad():
        expected = np.concatenate(
            [released.networks[pair](torch.from_numpy(part)).numpy() for part in np.split(planes, 10)]
        )
    found = np.concatenate(
        [exported.logits(maps.heights[n : n + 1], maps.roll[n], maps.pitch[n]) for n in range(len(maps))]
    )
    best, second = -np.partition(-expected, 1, axis=1)[:, :2].swapaxes(0, 1)
    differs = (found.argmax(axis=1) != expected.argmax(axis=1)) & (best - second > TIE)
    assert not differs.any()
    np.testing.assert_allclose(found, expected, atol=1e-3)
    assert len(np.unique(expected.argmax(axis=1))) >= 4


def test_a_training_can_go_on_from_the_folder(released, anymal_layout):
    info = read_model(released.out / "front.safetensors")[1]
    assert info["pair"] == "front" and info["dataset_sha256"] == "ab" * 32
    skeleton = LegSkeleton.from_dict(info["skeleton"])
    ones = np.ones(14, dtype=np.float32)
    learner = Learner(Recipe.from_dict(info["recipe"]), anymal_layout, ones, seed=9, skeleton=skeleton)
    start_from(learner, released.out, "front")
    # Kernels are released in bfloat16, everything else as it is.
    for name, tensor in released.networks["front"].state_dict().items():
        expected = tensor.bfloat16().float() if tensor.ndim == 4 else tensor
        assert torch.equal(learner.weights()[name], expected), name


def test_the_parity_report(released):
    reports = json.loads((released.out / "parity.json").read_text())
    for pair in PAIRS:
        float32, int8 = reports[pair]["float32"], reports[pair]["int8"]
        assert float32["maps"] == int8["maps"] == 60
        assert float32["cells"] == 60 * 1600
        assert float32["class_differs_beyond_ties"] == 0
        assert float32["max_logit_difference"] < 1e-3
        assert float32["cells_beyond_tolerance"] < 0.5 * float32["cells"]
        for report in (float32, int8):
            assert report["max_infeasible_difference"] < 1e-6
            assert report["max_cost_difference"] < 2e-4
            # The reference is slow and gets fewer maps; OpenVINO takes part where it is installed.
            engines = {name.split()[0]: figures for name, figures in report["other_engines"].items()}
            assert engines["onnx"]["maps"] == 1
            assert engines.get("openvino", float32)["maps"] == 60
        # What float32 itself leaves open.
        (double,) = (figures for name, figures in float32["other_engines"].items() if name.startswith("torch"))
        assert double["maps"] == 6 and 0 < double["max_logit_difference"] < 1e-3
        assert not any(name.startswith("torch") for name in int8["other_engines"])
        for figures in float32["other_engines"].values():
            assert figures["class_differs_beyond_ties"] == 0 and figures["max_logit_difference"] < 1e-3
        # Eight bits change something, but are the same network.
        assert 0 < int8["class_differs"] < 0.5 * int8["cells"]
        assert int8["max_logit_difference"] > float32["max_logit_difference"]


def test_an_export_that_differs_is_refused_and_leaves_nothing(released, monkeypatch, tmp_path):
    def spoiled(*_):
        model = without_decoding(onnx.load(released.out / "front.onnx"))
        bias = next(tensor for tensor in model.graph.initializer if tensor.name == "head.bias")
        wrong = onnx.numpy_helper.to_array(bias) + 0.1 * np.eye(14, dtype=np.float32)[0]
        bias.CopyFrom(onnx.numpy_helper.from_array(wrong, bias.name))
        return model

    monkeypatch.setattr(sources, "to_onnx", spoiled)
    with pytest.raises(ModelError, match=r"front.onnx says another class .* in \d+ of 16000 cells"):
        export_run(released.run, tmp_path / "out", parity_maps=10)
    assert list(tmp_path.iterdir()) == []


def test_the_runtime_selects_with_either_variant(released):
    course = make_course("steps", 3, size=4.0)
    for variant in ("float32", "int8"):
        selector = FootholdSelector.load(released.out, variant)
        for foothold in selector.select(course, (0, 0, 0.47, 0, 0, 0)).values():
            assert foothold.status == "ok" or foothold.reason


def test_a_mirrored_world_gives_the_mirrored_evaluation(released):
    """The real network, through the real file."""
    selector = FootholdSelector.load(released.out)
    heights = np.random.default_rng(0).uniform(-0.7, -0.3, (4, 40, 40))
    for left, right in (("LF", "RF"), ("LH", "RH")):
        one, other = (
            selector.evaluate(heights, left, 0.1, 0.05),
            selector.evaluate(heights[..., ::-1], right, -0.1, 0.05),
        )
        np.testing.assert_array_equal(one.feasible, other.feasible[..., ::-1])
        np.testing.assert_allclose(one.cost, other.cost[..., ::-1], atol=1e-3)


def test_the_contract_is_that_of_the_run(released, anymal_layout):
    for name in FILES:
        contract = Network.load(released.out / name).contract
        assert contract.layout.to_dict() == anymal_layout.to_dict()
        assert (contract.robot, contract.pair) == ("anymal_b", name.split(".")[0])
        assert (contract.feasible_below, contract.distance_weight) == (0.1, DISTANCE_WEIGHT)
        assert (contract.recipe, contract.dataset_sha256) == ("footsel", "ab" * 32)
        assert (contract.leg, contract.opset) == (TRAINED_LEG[contract.pair], 20)
        assert contract.commit == source_commit()


def test_the_files_carry_nothing_of_the_machine(released):
    for name in FILES:
        model = onnx.load(released.out / name)
        # Weights are numbers, in which any bytes may occur.
        for tensor in model.graph.initializer:
            tensor.ClearField("raw_data")
        assert [entry.key for entry in model.metadata_props] == ["footsel"]
        assert not re.search(rb"\.py\b|site-packages|stack_trace|/home|/root|/tmp", model.SerializeToString())


def test_the_graph_is_simplified_and_runs_on_the_oldest_onnxruntime(released):
    for pair in PAIRS:
        path = released.out / f"{pair}.onnx"
        assert path.stat().st_size < 7.6e6
        assert (released.out / f"{pair}.int8.onnx").stat().st_size < 2.5e6
        model = onnx.load(path)
        assert "BatchNormalization" not in {node.op_type for node in model.graph.node}
        assert [(entry.domain, entry.version) for entry in model.opset_import] == [("", 20)]
        # onnxruntime 1.18, the oldest that footsel accepts, reads IR version 10.
        assert model.ir_version <= 10


def test_the_card_says_what_was_run(released):
    card, epochs = (released.out / "model_card.md").read_text(), Recipe.load("footsel").epochs
    for words in (
        "# Foothold networks for anymal_b",
        "| training maps | 900 | 900 |",
        f"| epochs | 1 of {epochs} | 1 of {epochs} |",
        "The architecture is FootNet",
        "| recipe: schedule | one_cycle | one_cycle |",
        "87.50%",
        "| front | float32 | onnxruntime | 60 |",
        "footsel export RUN OUT --int8",
    ):
        assert words in card
    assert json.loads((released.out / "metrics.json").read_text())["hind"]["picks"]["missed"] == 3


def test_the_paper_recipe_is_exported(makers, anymal_layout, tmp_path):
    makers.write_run(tmp_path, anymal_layout, recipe="paper")
    source = sources.open_source(tmp_path, "front")
    exported = module.export_network(source, int8=False, parity_maps=20)
    assert set(exported.files) == {"front.onnx"}
    contract = Network.from_bytes(exported.files["front.onnx"], "front.onnx").contract
    assert (contract.recipe, contract.encoding.planes, contract.encoding.quantised) == ("paper", ("height",), True)
    card = model_card({"front": source.info, "hind": source.info}, {}, {})
    assert "does not see the base's tilt" in card and "The architecture is ERFNet" in card


def test_a_new_export_replaces_the_old_one_whole(released, tmp_path, monkeypatch):
    """A quantised variant of before goes away; what is not ours stays."""
    out = shutil.copytree(released.out, tmp_path / "out")
    (out / "notes.txt").write_text("mine")

    def without_int8(source, *_):
        name = f"{source.info['pair']}.onnx"
        return module.ExportedPair({name: (released.out / name).read_bytes()}, {})

    monkeypatch.setattr(module, "export_network", without_int8)
    export_run(released.run, out)
    assert {path.name for path in out.iterdir()} == {"front.onnx", "hind.onnx", "SHA256SUMS", "notes.txt"} | PAPERS
    assert FootholdSelector.load(out).robot == "anymal_b"


def test_a_release_is_exported_again_with_the_same_answers(released, anymal_layout, tmp_path):
    """From its own graphs, for the weights to train on from have fewer bits; what was measured of them stays."""
    out = export_run(released.out, tmp_path / "again", parity_maps=60)
    for pair in PAIRS:
        one, other = (Network.load(folder / f"{pair}.onnx") for folder in (released.out, out))
        maps = trial_maps(anymal_layout, TRAINED_LEG[pair], 20, seed=3)
        for before, after in zip(one.costs(maps.heights), other.costs(maps.heights), strict=True):
            np.testing.assert_array_equal(before, after)
        np.testing.assert_array_equal(one.logits(maps.heights), other.logits(maps.heights))
        assert one.contract.to_json() == other.contract.to_json()
    for name in ("metrics.json", *WEIGHTS):
        assert (out / name).read_bytes() == (released.out / name).read_bytes()
    before, after = (json.loads((folder / "parity.json").read_text()) for folder in (released.out, out))
    assert {pair: {"float32": before[pair]["float32"]} for pair in PAIRS} == after
    assert not (out / "front.int8.onnx").exists()


def test_a_changed_release_is_not_exported(released, tmp_path):
    changed = shutil.copytree(released.out, tmp_path / "changed")
    (changed / "metrics.json").write_text("{}")
    with pytest.raises(ModelError, match=r"metrics.json is not the file that was released"):
        export_run(changed, tmp_path / "out", parity_maps=1)


def test_an_8_bit_variant_of_a_release(released, monkeypatch):
    monkeypatch.setattr(module, "CALIBRATION_MAPS", 20)
    source = sources.open_source(released.out, "hind")
    exported = module.export_network(source, int8=True, parity_maps=10)
    assert set(exported.files) == {"hind.onnx", "hind.int8.onnx"}
    assert 0 < exported.parity["int8"]["class_differs"] < 0.5 * 16000


def test_the_graph_that_is_taken_over_ends_with_its_logits(released, anymal_layout):
    source = sources.open_source(released.out, "front")
    assert [output.name for output in source.model.graph.output] == ["logits"]
    assert source.model.graph.node[-1].output == ["logits"]
    maps = trial_maps(anymal_layout, "LF", 8, seed=4)
    exported = Network.load(released.out / "front.onnx")
    found = graph_logits(source.model)(exported.contract.encoding.encode(maps.heights, maps.roll, maps.pitch))
    np.testing.assert_array_equal(found, exported.logits(maps.heights, maps.roll, maps.pitch))


def test_a_run_without_one_pair_is_refused(released, tmp_path):
    shutil.copytree(released.run / "front", tmp_path / "run" / "front")
    with pytest.raises(ModelError, match=r"there is no .*hind.model.safetensors"):
        export_run(tmp_path / "run", tmp_path / "out", parity_maps=1)
    assert not (tmp_path / "out").exists()


def test_pairs_that_changed_places_are_refused(released, tmp_path):
    shutil.copytree(released.run / "hind", tmp_path / "run" / "front")
    with pytest.raises(ModelError, match="front was trained for the hind legs"):
        export_run(tmp_path / "run", tmp_path / "out", parity_maps=1)


def test_a_file_in_the_place_of_the_folder_is_refused(released, tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(InputError, match="is a file; give a folder"):
        export_run(released.run, tmp_path / "out")


def test_flat_ground_is_answered_alike_at_any_heading(released):
    """What depends on the heading frame alone does not change as the robot turns."""
    selector = FootholdSelector.load(released.out)
    flat = ElevationMap(np.zeros((200, 200)), 0.02)
    cells = {
        tuple(foothold.cell for foothold in selector.select(flat, (0, 0, 0.47, 0, 0, yaw)).values())
        for yaw in (0.0, 0.4, 1.9, -2.7)
    }
    assert len(cells) == 1


@pytest.mark.parametrize("package", ["torch", "onnx"])
def test_a_missing_package_names_the_extra(package):
    code = f"import sys; sys.modules[{package!r}] = None; import footsel.exporting; import footsel.exporting.export_run"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120)
    last = done.stderr.strip().splitlines()[-1]
    assert last.endswith(f"needs the package '{package}'; run: pip install 'footsel[train]'")


def test_weights_stay_behind_if_they_are_not_wanted(released, tmp_path):
    """A folder that held them loses them too, and loads all the same."""
    out = export_run(released.out, tmp_path / "light", parity_maps=2)
    assert (out / "front.safetensors").is_file()
    export_run(released.out, out, parity_maps=2, weights=False)
    assert {path.suffix for path in out.iterdir()} == {".onnx", ".json", ".md", ""}
    assert ".safetensors" not in (out / "SHA256SUMS").read_text() + (out / "model_card.md").read_text()
    FootholdSelector.load(out)
