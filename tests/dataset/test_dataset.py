"""What a dataset holds: labels of the stored maps, poses that lead back to the terrain, a manifest that seals it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footsel.dataset import open_dataset
from footsel.dataset.config import DatasetConfig
from footsel.dataset.labelling import make_samples
from footsel.dataset.samples import HEIGHT_STEP, decode_heights, encode_heights
from footsel.dataset.sampling import HEIGHT_SHARE, SamplingRecipe
from footsel.dataset.store import pack_shard, read_shard, shard_path, write_shard
from footsel.dataset.tally import tally_of, tally_shares
from footsel.errors import InputError, UnknownNameError
from footsel.footholds import BasePose, Reason
from footsel.footholds.cost import CLASSES, INFEASIBLE_COST, cost_to_class
from footsel.legs import PAIRS, TRAINED_LEG
from footsel.oracle import Oracle
from footsel.terrain import LocalMap
from footsel.terrain.courses import FAMILIES, make_course


def test_labels_are_the_oracle_s_of_the_stored_map(finished):
    """What is stored is enough to make the label again: heights as rounded, roll and pitch as kept."""
    oracle = Oracle.load("anymal_b")
    for pair, leg in TRAINED_LEG.items():
        samples = open_dataset(finished).load(pair)
        for index in range(len(samples)):
            heights = decode_heights(samples.heights_tenth_mm[index])
            local_map = LocalMap(heights, 0.02, np.zeros(3), 0.0)
            label = oracle.label(local_map, leg, float(samples.roll[index]), float(samples.pitch[index]))
            np.testing.assert_array_equal(label.reason, samples.reason[index])
            np.testing.assert_array_equal(label.cost_image, samples.cost[index])


def test_stored_maps_lie_on_their_courses(finished):
    """Family, course seed and pose of a sample lead back to its terrain, holes aside."""
    layout = Oracle.load("anymal_b").robot.layout
    samples = open_dataset(finished).load("front")
    for index in range(len(samples)):
        course = make_course(str(samples.family[index]), int(samples.course[index]))
        pose = BasePose(*samples.pose[index].astype(float).tolist())
        expected = layout.local_map(course, pose, "LF").heights
        stored = samples.heights()[index]
        both = ~np.isnan(stored) & ~np.isnan(expected)
        # The pose is kept as float32 and heights in steps of 0.1 mm; on a vertical face a micrometre moves more.
        assert np.quantile(np.abs(stored - expected)[both], 0.9) < 2 * HEIGHT_STEP


def test_bases_stand_within_the_drawn_heights_and_lower_ones_come_more_often():
    layout = Oracle.load("anymal_b").robot.layout
    sampling = SamplingRecipe.of("footsel")
    course, rng = make_course("flat", 0), np.random.default_rng(0)
    poses = np.array([sampling.draw_pose(rng, course, layout).as_list() for _ in range(2000)])
    share = poses[:, 2] / layout.standing_height
    low, high = HEIGHT_SHARE
    assert low <= share.min() < low + 0.01 and high - 0.01 < share.max() <= high
    assert 0.6 < (share < (low + high) / 2).mean() < 0.66  # 0.5 ** (1 / 1.5) = 0.63
    tilt = np.deg2rad(15)
    assert 0.95 * tilt < np.abs(poses[:, 3:5]).max() <= tilt and np.abs(poses[:, 5]).max() <= np.pi


def test_every_hard_constraint_decides_its_share():
    """The mix is hard: a network that ignored a constraint would be found out."""
    shares = []
    for pair in PAIRS:
        config = DatasetConfig("anymal_b", (pair,), 300, 11, "footsel", maps_per_shard=300, maps_per_course=1)
        tally = tally_of(make_samples(config, pair, 0))
        assert set(tally) == set(FAMILIES)
        shares.append(tally_shares(tally)["reason_shares"])
    for share in shares:
        assert share["KINEMATIC_RANGE"] >= 0.05 and share["TERRAIN_COLLISION"] >= 0.05
        assert share["SELF_COLLISION"] >= 0.02
        assert share["FEASIBLE"] >= 0.3 and sum(share.values()) == pytest.approx(1)


def test_cost_and_reason_agree(finished):
    samples = open_dataset(finished).load("hind")
    np.testing.assert_array_equal(samples.cost < INFEASIBLE_COST, samples.reason == Reason.FEASIBLE)
    np.testing.assert_array_equal(np.isnan(samples.heights()), samples.reason == Reason.UNKNOWN)


def test_manifest_describes_what_is_stored(finished, config):
    opened = open_dataset(finished)
    manifest = opened.manifest
    assert manifest["config"]["seed"] == config.seed and manifest["config"]["robot"] == "anymal_b"
    assert {"footsel", "numpy", "coal", "pinocchio", "python", "source"} <= set(manifest["versions"])
    loaded = {pair: opened.load(pair) for pair in PAIRS}
    everything = type(loaded["front"]).concatenate(list(loaded.values()))
    for entry, samples in ((manifest, everything), *((manifest["pairs"][pair], loaded[pair]) for pair in PAIRS)):
        assert set(entry["families"]) == set(samples.family.tolist())
        parts = [(entry, samples)]
        parts += [(part, samples.take(samples.family == name)) for name, part in entry["families"].items()]
        for part, of_part in parts:
            known = of_part.reason != Reason.UNKNOWN
            assert part["samples"] == len(of_part)
            assert part["unknown_share"] == pytest.approx(1 - known.mean())
            assert set(part["reason_shares"]) == {reason.name for reason in Reason} - {"UNKNOWN"}
            for name, share in part["reason_shares"].items():
                assert share == pytest.approx((of_part.reason[known] == Reason[name]).mean())
            classes = np.bincount(cost_to_class(of_part.cost).ravel(), minlength=CLASSES)
            np.testing.assert_allclose(part["class_shares"], classes / classes.sum())


def test_manifest_seals_the_shards(dataset):
    opened = open_dataset(dataset)
    opened.verify()
    shard_path(dataset, "front", 1).write_bytes(b"tampered")
    with pytest.raises(InputError, match="differs from the manifest"):
        opened.verify()


def test_split_shares_no_course(finished, config):
    training, validation = open_dataset(finished).split("front")
    assert len(training) + len(validation) == config.maps
    assert not set(training.course.tolist()) & set(validation.course.tolist())


def test_split_leaves_out_a_course_that_came_twice(dataset, config):
    """Plant the training's last course in the validation's shard."""
    last = config.shards - 1
    before, held = (read_shard(shard_path(dataset, "front", number)) for number in (last - 1, last))
    course = held.course.copy()
    course[:2] = before.course[0]
    write_shard(shard_path(dataset, "front", last), pack_shard(replace(held, course=course)))
    training, validation = open_dataset(dataset).split("front")
    assert len(validation) == len(held) - 2 and len(training) == config.maps - len(held)
    assert before.course[0] not in validation.course


def test_samples_are_split_by_family(finished):
    opened = open_dataset(finished)
    everything = opened.load("front")
    family = str(everything.family[0])
    chosen, others = opened.load("front", families=[family]), opened.load("front", exclude=[family])
    assert set(chosen.family.tolist()) == {family} and family not in others.family
    assert len(chosen) + len(others) == len(everything) and len(chosen) > 0
    training, validation = opened.split("front", exclude=[family])
    assert len(training) + len(validation) == len(others)
    with pytest.raises(UnknownNameError, match="lava"):
        opened.split("front", exclude=["lava"])
    with pytest.raises(UnknownNameError, match="lava"):
        opened.load("front", families=["lava"])


def test_damaged_manifest_and_shard_are_named(dataset: Path):
    shard_path(dataset, "front", 0).write_bytes(b"not a shard")
    with pytest.raises(InputError, match="shard_00000"):
        open_dataset(dataset).load("front")
    (dataset / "manifest.json").write_text(json.dumps({"pairs": {}}))
    with pytest.raises(InputError, match="damaged"):
        open_dataset(dataset)


def test_heights_round_to_a_tenth_of_a_millimetre():
    heights = np.array([0.0, -0.48765, 0.1, np.nan, 9.0, -9.0])
    decoded = decode_heights(encode_heights(heights))
    assert np.isnan(decoded[3])
    assert np.abs(decoded[:3] - heights[:3]).max() <= HEIGHT_STEP / 2 + 1e-7
    np.testing.assert_allclose(decoded[4:], [3.2767, -3.2767], atol=1e-6)


def test_paper_recipe_is_level_and_turns_by_quarters(config):
    samples = make_samples(replace(config, pairs=("front",), maps=4, recipe="paper"), "front", 0)
    assert not samples.roll.any() and not samples.pitch.any()
    quarters = samples.pose[:, 5] / (np.pi / 2)
    np.testing.assert_allclose(quarters, np.rint(quarters), atol=1e-6)
    assert set(samples.family.tolist()) == {"composed"}


def test_four_headings_are_all_that_differs_from_footsel(config):
    any_heading, four = (
        make_samples(replace(config, pairs=("front",), recipe=recipe), "front", 0)
        for recipe in ("footsel", "four_headings")
    )
    quarters = four.pose[:, 5] / (np.pi / 2)
    np.testing.assert_allclose(quarters, np.rint(quarters), atol=1e-6)
    assert not np.isclose(np.sin(2 * any_heading.pose[:, 5]), 0, atol=1e-3).all()
    assert four.roll.any() and np.isnan(four.heights()).any() and len(set(four.family.tolist())) > 1
    assert replace(SamplingRecipe.of("four_headings"), quarter_turns=False) == SamplingRecipe.of("footsel")


def test_families_can_be_left_out(config):
    assert set(SamplingRecipe.of("footsel", exclude=("pillars", "rubble")).families) == set(FAMILIES) - {
        "pillars",
        "rubble",
    }
    assert SamplingRecipe.of("footsel", families=("flat",)).families == ("flat",)
    # The paper's one map is composed of the others; families that are asked for come as courses of their own.
    assert SamplingRecipe.of("paper", exclude=("pillars",), map_seed=3).map_seed == 3
    assert SamplingRecipe.of("paper", families=("pillars",), map_seed=3).map_seed is None
    for wrong in ({"families": ("lava",)}, {"exclude": ("lava",)}, {"recipe": "cake"}, {"robot": "cat"}):
        with pytest.raises(UnknownNameError, match=r"lava|cake|cat"):
            replace(config, **wrong)
    for wrong in ({"families": ("flat",), "exclude": ("flat",)}, {"pairs": ()}, {"maps": 0}, {"maps_per_shard": 0}):
        with pytest.raises(InputError):
            replace(config, **wrong)
