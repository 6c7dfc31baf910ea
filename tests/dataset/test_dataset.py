"""Datasets: the same bytes for the same seed, whoever makes them and however often they are killed."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from footsel.dataset import generate as generation
from footsel.dataset import open_dataset
from footsel.dataset.generate import DatasetConfig, generate, make_samples
from footsel.dataset.samples import HEIGHT_STEP, decode_heights, encode_heights
from footsel.dataset.sampling import SamplingRecipe
from footsel.dataset.store import shard_path
from footsel.errors import InputError, UnknownNameError
from footsel.footholds import BasePose, Reason
from footsel.footholds.cost import INFEASIBLE_COST
from footsel.legs import TRAINED_LEG
from footsel.oracle import Oracle
from footsel.terrain import LocalMap
from footsel.terrain.courses import FAMILIES, make_course

CONFIG = DatasetConfig(robot="anymal_b", pairs=("front", "hind"), maps=12, seed=3, recipe="footsel")


@pytest.fixture(autouse=True)
def small_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generation, "SAMPLES_PER_SHARD", 4)
    monkeypatch.setattr(generation, "SAMPLES_PER_COURSE", 2)


def digests(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


@pytest.fixture
def dataset(tmp_path: Path) -> Path:
    return generate(CONFIG, tmp_path / "whole", jobs=1).parent


def test_another_run_gives_the_same_bytes(dataset: Path, tmp_path: Path) -> None:
    again = generate(CONFIG, tmp_path / "again", jobs=1).parent
    assert digests(again) == digests(dataset)


def test_an_interrupted_run_is_finished_with_the_same_bytes(dataset: Path) -> None:
    complete = digests(dataset)
    for number in (0, 2):
        shard_path(dataset, "hind", number).unlink()
    (dataset / "manifest.json").unlink()
    (dataset / "front" / ".shard_00001.4711.tmp.npz").write_bytes(b"half a shard")
    with pytest.raises(InputError, match="no finished dataset"):
        open_dataset(dataset)
    generate(CONFIG, dataset, jobs=1)
    remade = digests(dataset)
    assert {name: remade[name] for name in complete} == complete


def test_another_configuration_is_refused(dataset: Path) -> None:
    other = DatasetConfig(robot="anymal_b", pairs=("front",), maps=12, seed=4, recipe="footsel")
    with pytest.raises(InputError, match="another configuration"):
        generate(other, dataset, jobs=1)


def test_a_folder_with_other_things_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="not empty"):
        generate(CONFIG, tmp_path, jobs=1)


def test_labels_are_the_oracle_s_of_the_stored_map(dataset: Path) -> None:
    """What is stored is enough to make the label again: heights as rounded, roll and pitch as kept."""
    oracle = Oracle.load("anymal_b")
    for pair, leg in TRAINED_LEG.items():
        samples = open_dataset(dataset).load(pair)
        for index in range(len(samples)):
            heights = decode_heights(samples.heights_tenth_mm[index])
            local_map = LocalMap(heights, 0.02, np.zeros(3), 0.0)
            label = oracle.label(local_map, leg, float(samples.roll[index]), float(samples.pitch[index]))
            np.testing.assert_array_equal(label.reason, samples.reason[index])
            np.testing.assert_array_equal(label.cost_image, samples.cost[index])


def test_stored_maps_lie_on_their_courses(dataset: Path) -> None:
    """Family, course seed and pose of a sample lead back to its terrain, holes aside."""
    layout = Oracle.load("anymal_b").robot.layout
    samples = open_dataset(dataset).load("front")
    for index in range(len(samples)):
        course = make_course(str(samples.family[index]), int(samples.course[index]))
        pose = BasePose(*samples.pose[index].astype(float).tolist())
        expected = layout.local_map(course, pose, "LF").heights
        stored = samples.heights()[index]
        both = ~np.isnan(stored) & ~np.isnan(expected)
        # The pose is kept as float32 and heights in steps of 0.1 mm; on a vertical face a micrometre moves more.
        assert np.quantile(np.abs(stored - expected)[both], 0.9) < 2 * HEIGHT_STEP


def test_cost_and_reason_agree(dataset: Path) -> None:
    samples = open_dataset(dataset).load("hind")
    np.testing.assert_array_equal(samples.cost < INFEASIBLE_COST, samples.reason == Reason.FEASIBLE)
    np.testing.assert_array_equal(np.isnan(samples.heights()), samples.reason == Reason.UNKNOWN)


def test_manifest_describes_and_seals_the_shards(dataset: Path) -> None:
    opened = open_dataset(dataset)
    opened.verify()
    entry = opened.manifest["pairs"]["front"]
    samples = opened.load("front")
    assert entry["samples"] == len(samples) == CONFIG.maps
    known = samples.reason != Reason.UNKNOWN
    expected = float((samples.reason == Reason.TERRAIN_COLLISION).sum() / known.sum())
    assert entry["reason_shares"]["TERRAIN_COLLISION"] == pytest.approx(expected)
    assert sum(entry["class_shares"]) == pytest.approx(1.0)
    assert sum(family["samples"] for family in entry["families"].values()) == CONFIG.maps
    shard_path(dataset, "front", 1).write_bytes(b"tampered")
    with pytest.raises(InputError, match="differs from the manifest"):
        opened.verify()


def test_split_shares_no_course(dataset: Path) -> None:
    training, validation = open_dataset(dataset).split("front")
    assert len(training) + len(validation) == CONFIG.maps
    assert not set(training.course.tolist()) & set(validation.course.tolist())


def test_damaged_manifest_and_shard_are_named(dataset: Path) -> None:
    shard_path(dataset, "front", 0).write_bytes(b"not a shard")
    with pytest.raises(InputError, match="shard_00000"):
        open_dataset(dataset).load("front")
    (dataset / "manifest.json").write_text(json.dumps({"pairs": {}}))
    with pytest.raises(InputError, match="damaged"):
        open_dataset(dataset)


def test_heights_round_to_a_tenth_of_a_millimetre() -> None:
    heights = np.array([0.0, -0.48765, 0.1, np.nan, 9.0, -9.0])
    decoded = decode_heights(encode_heights(heights))
    assert np.isnan(decoded[3])
    assert np.abs(decoded[:3] - heights[:3]).max() <= HEIGHT_STEP / 2 + 1e-7
    np.testing.assert_allclose(decoded[4:], [3.2767, -3.2767], atol=1e-6)


def test_paper_recipe_is_level_and_turns_by_quarters() -> None:
    config = DatasetConfig(robot="anymal_b", pairs=("front",), maps=4, seed=1, recipe="paper")
    samples = make_samples(config, "front", 0)
    assert not samples.roll.any() and not samples.pitch.any()
    quarters = samples.pose[:, 5] / (np.pi / 2)
    np.testing.assert_allclose(quarters, np.rint(quarters), atol=1e-6)
    assert set(samples.family.tolist()) == {"composed"}


def test_families_can_be_left_out() -> None:
    recipe = SamplingRecipe.of("footsel", exclude=("pillars", "rubble"))
    assert set(recipe.families) == set(FAMILIES) - {"pillars", "rubble"}
    assert SamplingRecipe.of("footsel", families=("flat",)).families == ("flat",)
    for wrong in ({"families": ("lava",)}, {"exclude": ("lava",)}):
        with pytest.raises(UnknownNameError, match="lava"):
            SamplingRecipe.of("footsel", **wrong)
    with pytest.raises(InputError):
        SamplingRecipe.of("footsel", families=("flat",), exclude=("flat",))


def test_bytes_do_not_depend_on_the_number_of_jobs(tmp_path: Path) -> None:
    """Worker processes read the module's own shard size, so this one runs with it: two shards of one map each."""
    config = DatasetConfig(robot="anymal_b", pairs=("front", "hind"), maps=1, seed=5, recipe="footsel")
    assert digests(generate(config, tmp_path / "one", jobs=1).parent) == digests(
        generate(config, tmp_path / "two", jobs=2).parent
    )
