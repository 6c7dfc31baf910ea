"""The whole way through the command line, tiny: dataset, training, evaluation, export, selection."""

import json

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.benchmark.baselines import torch_baselines
from footsel.benchmark.cases import make_cases
from footsel.benchmark.models import time_models
from footsel.cli.main import main
from footsel.legs import LEGS


@pytest.fixture(scope="module")
def workplace(tmp_path_factory):
    """Folder in which each step has left its files; a step that failed fails the tests that read them."""
    root = tmp_path_factory.mktemp("whole_way")
    dataset, run = str(root / "data"), str(root / "run")
    made = ["dataset", dataset, "--maps", "16", "--seed", "5", "--jobs", "1", "--exclude", "pillars"]
    made += ["--maps-per-shard", "8"]
    assert main(made) == 0
    assert main(made) == 0  # A finished dataset is left as it is.
    assert main(["train", dataset, run, "--epochs", "1"]) == 0
    assert main(["train", dataset, run, "--epochs", "1"]) == 2  # It holds a training already.
    assert main(["train", dataset, run, "--epochs", "1", "--resume"]) == 0
    assert main(["export", run, str(root / "model"), "--parity-maps", "22"]) == 0
    for model in ("run", "model"):
        assert main(["evaluate", str(root / model), dataset, "--out", str(root / f"{model}.json")]) == 0
    return root


def test_dataset(workplace):
    manifest = json.loads((workplace / "data" / "manifest.json").read_text())
    assert set(manifest["pairs"]) == {"front", "hind"}
    for entry in manifest["pairs"].values():
        assert entry["samples"] == 16 and len(entry["shards"]) == 2 and "pillars" not in entry["families"]


def test_checkpoint_and_exported_model_have_the_same_figures(workplace):
    trained, exported = (json.loads((workplace / f"{name}.json").read_text())["networks"] for name in ("run", "model"))
    assert set(trained) == set(exported) == {"front", "hind"}
    for pair, figures in trained.items():
        assert figures["all"]["maps"] == exported[pair]["all"]["maps"] == 16
        for key, value in figures["all"]["cells_likeliest"].items():
            if isinstance(value, float):
                assert exported[pair]["all"]["cells_likeliest"][key] == pytest.approx(value, abs=1e-3), key


def test_torch_is_a_baseline_of_the_benchmark(workplace, anymal_layout):
    cases = make_cases(anymal_layout, 3, seed=0)
    with torch_baselines(workplace / "run", workplace / "model") as baselines:
        _, beside = time_models(workplace / "model", cases, baselines)
    assert set(beside) == {"torch_eager", "onnxruntime_unsimplified"}
    assert all(times["network_ms"]["p50"] > 0 for times in beside.values())


def test_select_with_the_exported_model(workplace, capsys):
    ElevationMap(np.zeros((150, 150)), 0.02).save(workplace / "flat.npz")
    capsys.readouterr()
    pose = ["--pose", "-1e-05", "0", "auto", "0", "0", "1.5"]
    assert main(["select", str(workplace / "flat.npz"), *pose, "--model", str(workplace / "model")]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert list(answer["footholds"]) == list(LEGS)
    for foothold in answer["footholds"].values():
        # One epoch on eight maps teaches nothing: any answer will do, if it is a whole one.
        assert foothold["status"] in ("ok", "none")
        assert (foothold["position"] is None) == (foothold["reason"] is not None)
