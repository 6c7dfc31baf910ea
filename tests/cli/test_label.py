"""`footsel label`: the file's contract, and that it is the oracle's answer."""

import numpy as np
import pytest
from PIL import Image

from footsel import ElevationMap
from footsel.footholds import REASON_NAMES, BasePose
from footsel.oracle import Oracle

POSE = ("0.2", "-0.1", "0.57", "-1e-05", ".05", "+0.7")


@pytest.fixture
def label(footsel, bumpy_map, tmp_path):
    outcome = footsel("label", bumpy_map, "--leg", "RH", "--pose", *POSE, "--out", tmp_path / "label.npz")
    assert outcome.code == 0 and outcome.err == "" and "1600 cells" in outcome.out
    with np.load(tmp_path / "label.npz", allow_pickle=False) as stored:
        return dict(stored)


def test_shapes_and_types(label):
    assert label["cost"].shape == label["reason"].shape == (40, 40)
    assert label["cost"].dtype == label["reason"].dtype == np.uint8
    assert label["reason_names"].dtype.kind == "U" and tuple(label["reason_names"]) == REASON_NAMES
    for key in ("kinematic_margin", "terrain_cost", "heights"):
        assert label[key].shape == (40, 40) and label[key].dtype.kind == "f"
    assert label["positions"].shape == (40, 40, 3)


def test_it_is_the_oracles_answer(label, bumpy_map):
    oracle = Oracle.load("anymal_b")
    pose = BasePose.of([float(word) for word in POSE])
    local_map = oracle.robot.layout.local_map(ElevationMap.load(bumpy_map), pose, "RH")
    expected = oracle.label(local_map, "RH", pose.roll, pose.pitch)
    np.testing.assert_array_equal(label["cost"], expected.cost_image)
    np.testing.assert_array_equal(label["reason"], expected.reason)
    np.testing.assert_allclose(label["kinematic_margin"], expected.kinematic_margin, atol=1e-6)
    np.testing.assert_allclose(label["terrain_cost"], expected.terrain_cost, atol=1e-6)
    np.testing.assert_array_equal(label["positions"], local_map.positions())


def test_the_parts_agree_with_each_other(label):
    names = label["reason_names"][label["reason"]]
    assert (names == "UNKNOWN").any() and (names == "FEASIBLE").any()
    np.testing.assert_array_equal(label["cost"] == 255, names != "FEASIBLE")
    np.testing.assert_array_equal(np.isnan(label["heights"]), names == "UNKNOWN")
    np.testing.assert_array_equal(np.isnan(label["positions"][..., 2]), names == "UNKNOWN")
    np.testing.assert_array_equal(np.isnan(label["kinematic_margin"]), names != "FEASIBLE")
    assert np.isfinite(label["positions"][..., :2]).all()
    # Heights are relative to L_i, positions to the world: they differ by the hip's height alone.
    hip_height = (label["positions"][..., 2] - label["heights"])[names != "UNKNOWN"]
    assert np.ptp(hip_height) < 1e-6


def test_the_parts_that_explain_agree_with_the_reasons(label):
    names = label["reason_names"][label["reason"]]
    assert label["joint_angles"].shape == (40, 40, 3) and label["joint_angles"].dtype == np.float32
    out_of_range = np.isin(names, ["UNKNOWN", "KINEMATIC_RANGE"])
    np.testing.assert_array_equal(np.isnan(label["joint_angles"]).any(axis=-1), out_of_range)
    assert label["touching"].shape == (40, 40, 2) and label["touching"].dtype == np.uint8
    assert label["body_names"].dtype.kind == "U"
    swing, other = np.moveaxis(label["body_names"][label["touching"]], -1, 0)
    collides = np.isin(names, ["SELF_COLLISION", "TERRAIN_COLLISION"])
    assert collides.any()
    np.testing.assert_array_equal(np.char.startswith(swing, "RH_"), collides)
    np.testing.assert_array_equal(other == "terrain", names == "TERRAIN_COLLISION")
    np.testing.assert_array_equal((swing == "") & (other == ""), ~collides)


def test_one_cell_in_words(footsel, bumpy_map, label):
    arguments = ("label", bumpy_map, "--leg", "RH", "--pose", *POSE)
    for reason in np.unique(label["reason"]):
        i, j = np.argwhere(label["reason"] == reason)[0]
        outcome = footsel(*arguments, "--cell", i, j)
        assert outcome.code == 0 and outcome.err == ""
        name = label["reason_names"][reason].lower()
        assert outcome.out.startswith(f"RH cell {i} {j} at x=")
        assert name.replace("_", " ") in outcome.out.replace("-", " ")
        if label["touching"][i, j].any():
            swing, other = label["body_names"][label["touching"][i, j]]
            assert f"{swing} against {other}" in outcome.out
        x, y = label["positions"][i, j, :2]
        assert footsel(*arguments, "--at", x, y).out == outcome.out


def test_cells_that_do_not_exist(footsel, bumpy_map):
    arguments = ("label", bumpy_map, "--leg", "RH", "--pose", *POSE)
    assert footsel(*arguments, "--cell", 40, 0).complains("cell 40 0", "39 39")
    assert footsel(*arguments, "--cell", "-1", 0).complains("'-1'", "0 or more")
    assert footsel(*arguments, "--cell", 3).complains("--cell")
    assert footsel(*arguments, "--at", 3, 0).complains("x=3 y=0", "not on the local map")
    assert footsel(*arguments, "--at", 0, 0, "--cell", 1, 1).complains("not allowed with")
    assert footsel(*arguments).complains("nothing to do", "--out")


def test_help_says_what_the_file_holds(footsel, label):
    text = footsel("label", "--help").out
    for key in label:
        assert key in text


def test_plot(footsel, bumpy_map, tmp_path, level_pose):
    out, plot = tmp_path / "label.npz", tmp_path / "label.png"
    assert footsel("label", bumpy_map, "--leg", "LF", *level_pose, "--out", out, "--plot", plot).code == 0
    with Image.open(plot) as image:
        assert image.format == "PNG" and min(image.size) > 1000


@pytest.mark.parametrize("target", ["no/such/folder/label.npz", "a_folder"])
def test_nothing_is_written_where_it_cannot_be(footsel, bumpy_map, tmp_path, level_pose, target):
    (tmp_path / "a_folder").mkdir()
    outcome = footsel("label", bumpy_map, "--leg", "LF", *level_pose, "--out", tmp_path / target)
    assert outcome.complains(target.rpartition("/")[0] or target)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a_folder", "bumpy.npz"]


def test_a_failed_write_leaves_the_old_file(footsel, bumpy_map, tmp_path, level_pose, monkeypatch):
    out = tmp_path / "label.npz"
    out.write_bytes(b"old")

    def full_disk(*_, **__):
        raise OSError(28, "No space left on device", str(out))

    monkeypatch.setattr(np, "savez_compressed", full_disk)
    assert footsel("label", bumpy_map, "--leg", "LF", *level_pose, "--out", out).complains("No space left")
    assert out.read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bumpy.npz", "label.npz"]
