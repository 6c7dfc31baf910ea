"""A dataset folder in, metrics out: training from disk, and the same figures from a checkpoint and its ONNX file."""

import json
from dataclasses import replace

import pytest

from footsel.cli.main import main
from footsel.dataset.store import (
    MANIFEST,
    open_dataset,
    pack_shard,
    pair_entry,
    record_shard,
    shard_path,
    write_shard,
)
from footsel.errors import InputError, ModelError, UnknownNameError
from footsel.exporting.decoding import with_decoding
from footsel.exporting.onnx_file import OPSET, to_onnx, with_contract
from footsel.files import write_json
from footsel.footholds import DISTANCE_WEIGHT, LegLayout
from footsel.footholds.encoding import InputEncoding
from footsel.learning.checkpoint import load_network
from footsel.learning.degraded import Degradation
from footsel.learning.evaluate import evaluate_model, find_models
from footsel.learning.recipe import Recipe
from footsel.learning.train import load_data, train
from footsel.legs import TRAINED_LEG
from footsel.robot import load_robot
from footsel.runtime.contract import FRAME, ModelContract


@pytest.fixture(scope="module")
def dataset_dir(make_samples, tmp_path_factory):
    folder = tmp_path_factory.mktemp("dataset")
    shards = [make_samples(12, 1), make_samples(6, 2)]
    for number, shard in enumerate(shards):
        write_shard(shard_path(folder, "front", number), pack_shard(shard))
    entry = pair_entry([record_shard(folder, "front", number) for number in range(len(shards))])
    config = {"robot": "anymal_b", "maps": 18, "seed": 1, "recipe": "footsel", "families": [], "exclude": []}
    write_json(folder / MANIFEST, {"config": config, "pairs": {"front": entry}})
    return folder


@pytest.fixture(scope="module")
def run(dataset_dir, tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    train(dataset_dir, out, "front", replace(Recipe.load("footsel"), batch_size=6), epochs=1)
    return out


def test_training_from_disk_holds_the_last_shard_back(dataset_dir, run):
    _, info = load_network(run / "front")
    assert info["maps"] == {"training": 12, "validation": 6} and info["robot"] == "anymal_b"
    assert info["dataset_sha256"] == open_dataset(dataset_dir).sha256
    assert info["layout"] == load_robot("anymal_b").layout.to_dict()
    with pytest.raises(InputError, match="has no hind legs"):
        train(dataset_dir, run, "hind", Recipe.load("footsel"))


def test_checkpoint_and_onnx_give_the_same_figures(dataset_dir, run, tmp_path, flat):
    net, info = load_network(run / "front")
    contract = ModelContract(
        robot=info["robot"],
        pair=info["pair"],
        leg=TRAINED_LEG[info["pair"]],
        frame=FRAME,
        layout=LegLayout.from_dict(info["layout"]),
        encoding=InputEncoding.from_dict(info["encoding"]),
        classes=info["classes"],
        feasible_below=info["feasible_below"],
        distance_weight=DISTANCE_WEIGHT,
        recipe=info["recipe"]["name"],
        dataset_sha256=info["dataset_sha256"],
        version=info["version"],
        opset=OPSET,
        commit="",
    )
    model = with_decoding(to_onnx(net, net.in_channels))
    (tmp_path / "front.onnx").write_bytes(with_contract(model, contract))
    out = tmp_path / "metrics.json"
    ours = evaluate_model(run, dataset_dir, out)
    assert json.loads(out.read_text()) == ours
    exported = evaluate_model(tmp_path / "front.onnx", dataset_dir)
    assert ours["networks"].keys() == exported["networks"].keys() == {"front"}
    checkpoint, onnx = (figures["networks"]["front"] for figures in (ours, exported))
    assert checkpoint["feasible_below"] == onnx["feasible_below"]
    assert checkpoint.pop("pair") == onnx.pop("pair") == "front"
    assert set(checkpoint["families"]) == {"steps", "blocks"} and checkpoint["all"]["maps"] == 18
    ours, theirs = flat(checkpoint), flat(onnx)
    assert ours.keys() == theirs.keys() and len(ours) > 500
    for key, value in ours.items():
        if ".bins." in key:  # a probability at a bin's edge may fall to either side
            continue
        assert theirs[key] == (None if value is None else pytest.approx(value, rel=1e-4, abs=1e-4)), key


def test_only_the_families_asked_for(dataset_dir, run):
    figures = evaluate_model(run, dataset_dir, families=["steps"])["networks"]["front"]
    assert list(figures["families"]) == ["steps"] and figures["all"]["maps"] == 9
    with pytest.raises(InputError, match="no maps of these families"):
        evaluate_model(run, dataset_dir, families=["stairs"])
    with pytest.raises(UnknownNameError, match=r"'moon'; choose from: .*steps"):
        evaluate_model(run, dataset_dir, families=["moon"])


def test_degraded_input_is_judged_by_the_true_labels(dataset_dir, run, flat):
    clean, noisy, again, other = (
        evaluate_model(run, dataset_dir, degradation=degradation)
        for degradation in (None, *(Degradation("d435", 0.2, seed) for seed in (0, 0, 1)))
    )
    assert noisy == again and noisy["degradation"] == {"noise": "d435", "holes": 0.2, "seed": 0}
    assert clean["degradation"] is None
    clean, noisy, other = (each["networks"]["front"]["all"] for each in (clean, noisy, other))
    assert flat(noisy) != flat(other)
    cells = [sum(each["cells"]["cells_by_reason"].values()) for each in (clean, noisy)]
    # A fifth of all cells is lost, of the 98 % that were known too.
    assert cells[1] == pytest.approx(cells[0] - 0.2 * 0.98 * 18 * 1600, rel=0.02)
    assert noisy["picks"]["unknown_picks"] == 0 and noisy["maps"] == 18


def test_the_command_writes_figures_and_a_sheet(dataset_dir, run, tmp_path, capsys):
    out, sheet = tmp_path / "metrics.json", tmp_path / "sheet.png"
    degradation = ("--noise", "d435", "--holes", "0.2", "--seed", "5")
    assert main(["evaluate", *map(str, (run, dataset_dir, "--out", out, "--plot", sheet, *degradation))]) == 0
    expected = evaluate_model(run, dataset_dir, degradation=Degradation("d435", 0.2, 5))
    assert json.loads(out.read_text()) == expected
    assert "missed" in capsys.readouterr().out and sheet.stat().st_size > 10_000
    # A seed alone degrades nothing.
    assert main(["evaluate", *map(str, (run, dataset_dir, "--out", out, "--seed", 5))]) == 0
    assert json.loads(out.read_text())["degradation"] is None


@pytest.mark.parametrize("wrong", [("--noise", "kinect"), ("--holes", "1"), ("--holes", "-.1"), ("--holes", "many")])
def test_wrong_degradations_are_refused_in_a_line(dataset_dir, run, tmp_path, capsys, wrong):
    assert main(["evaluate", str(run), str(dataset_dir), "--out", str(tmp_path / "m.json"), *wrong]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1 and not (tmp_path / "m.json").exists()


def test_nothing_to_evaluate_is_said(tmp_path):
    with pytest.raises(ModelError, match="no trained network at"):
        find_models(tmp_path)


def test_a_family_left_out_of_training_is_judged_as_unseen(dataset_dir, tmp_path, script):
    data = load_data(dataset_dir, "front", exclude=("steps",))
    assert set(data.training.family) == set(data.validation.family) == {"blocks"}
    with pytest.raises(UnknownNameError, match="'moon'"):
        load_data(dataset_dir, "front", exclude=("moon",))

    train(dataset_dir, tmp_path, "front", replace(Recipe.load("footsel"), batch_size=6), epochs=1, exclude=("steps",))
    _, info = load_network(tmp_path / "front")
    assert info["dataset"]["exclude"] == ["steps"] and info["maps"]["training"] == len(data.training)
    judged = evaluate_model(tmp_path, dataset_dir, families=["steps"])["networks"]["front"]["all"]
    found = script("judge").held_out(tmp_path, dataset_dir)["networks"]["front"]
    assert found["exclude"] == ["steps"] and set(found["families"]) == {"steps"}
    assert found["unseen"]["picks"] == judged["picks"] and found["unseen"]["maps"] == found["seen"]["maps"] == 9


def test_a_network_that_saw_all_families_has_none_to_be_judged_unseen(dataset_dir, run, script):
    with pytest.raises(InputError, match="trained on all families"):
        script("judge").held_out(run, dataset_dir)
