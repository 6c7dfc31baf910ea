"""Bad maps, poses, names and models: one line that names the value and the remedy, and nothing written."""

import numpy as np
import pytest
from rosbags.rosbag1 import Writer

SELECT_POSE = ("--pose", "0", "0", "0.6", "0", "0", "0")


def npz(path, **arrays):
    np.savez(path, **arrays)


FLAT = np.zeros((60, 60), dtype=np.float32)
BAD_MAPS = {
    "missing": (None, ("no such file",)),
    "wrong keys": ({"height": FLAT, "resolution": 0.02}, ("lacks elevation", "height")),
    "no resolution": ({"elevation": FLAT}, ("lacks resolution",)),
    "wrong shape": ({"elevation": np.zeros(7), "resolution": 0.02}, ("(7,)", "2-D")),
    "all NaN": ({"elevation": np.full((9, 9), np.nan), "resolution": 0.02}, ("NaN",)),
    "infinite": ({"elevation": np.full((9, 9), np.inf), "resolution": 0.02}, ("infinite", "NaN")),
    "zero resolution": ({"elevation": FLAT, "resolution": 0.0}, ("0.0", "above 0")),
    "negative resolution": ({"elevation": FLAT, "resolution": -0.02}, ("-0.02", "above 0")),
    "pickled": ({"elevation": np.array([[{}]], dtype=object), "resolution": 0.02}, ()),
}


@pytest.fixture(params=BAD_MAPS)
def bad_map(request, tmp_path):
    arrays, words = BAD_MAPS[request.param]
    path = tmp_path / "bad.npz"
    if arrays is not None:
        npz(path, **arrays)
    return path, words


def test_bad_maps(footsel, bad_map, tmp_path):
    path, words = bad_map
    before = sorted(tmp_path.iterdir())
    assert footsel("select", path, *SELECT_POSE).complains("bad.npz", *words)
    label = footsel(
        "label", path, *SELECT_POSE, "--leg", "LF", "--out", tmp_path / "l.npz", "--plot", tmp_path / "p.png"
    )
    assert label.complains("bad.npz", *words)
    assert sorted(tmp_path.iterdir()) == before


def test_an_image_needs_metres(footsel, tmp_path):
    (tmp_path / "m.png").write_bytes(b"\x89PNG")
    assert footsel("select", tmp_path / "m.png", *SELECT_POSE).complains("--png-range LOW HIGH")
    ranged = ("--png-range", "-1e-1", "-.05")
    assert footsel("select", tmp_path / "m.png", *SELECT_POSE, *ranged).complains("--resolution R")


def test_a_bag_without_the_layer(footsel, tmp_path):
    with Writer(tmp_path / "empty.bag"):
        pass
    assert footsel("select", tmp_path / "empty.bag", *SELECT_POSE, "--layer", "wool").complains("empty.bag")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--pose", "9", "0", "0.5", "0", "0", "0"), ("x=9 y=0", "off the map", "-1.5..1.5")),
        (("--pose", "9", "0", "auto", "0", "0", "0"), ("off the map",)),
        (("--pose", "nan", "0", "0.5", "0", "0", "0"), ("X of --pose", "nan")),
        (("--pose", "0", "0", "0.5", "0", "0", "-inf"), ("YAW of --pose", "-inf")),
        (("--pose", "0", "0", "high", "0", "0", "0"), ("Z of --pose", "high")),
        (("--pose", "0", "0", "0.5"), ("--pose", "6")),
        ((*SELECT_POSE, "--legs", "XX"), ("unknown leg 'XX'", "LF, RF, LH, RH")),
        ((*SELECT_POSE, "--robot", "spot"), ("unknown robot 'spot'", "anymal_b")),
        ((*SELECT_POSE, "--selector", "psychic"), ("unknown selector 'psychic'", "oracle")),
        ((*SELECT_POSE, "--top-k", "0"), ("'0'", "1 or more")),
        ((*SELECT_POSE, "--model", "no/such/model"), ("no/such/model",)),
        ((*SELECT_POSE, "--plot", "no/folder/p.png"), ("no/folder",)),
        ((*SELECT_POSE, "--resolution", "fine"), ("'fine'",)),
        ((*SELECT_POSE, "--frobnicate"), ("--frobnicate", "footsel select --help")),
    ],
)
def test_bad_arguments_of_select(footsel, bumpy_map, model_folder, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.iterdir())
    assert footsel("select", bumpy_map, "--model", model_folder, *arguments).complains(*words)
    assert sorted(tmp_path.iterdir()) == before


def test_bad_arguments_of_label(footsel, bumpy_map, tmp_path):
    out = ("--out", tmp_path / "l.npz")
    assert footsel("label", bumpy_map, *SELECT_POSE, "--leg", "lf", *out).complains("'lf'", "LF")
    assert footsel("label", bumpy_map, *SELECT_POSE, *out).complains("--leg")
    assert not (tmp_path / "l.npz").exists()


def test_bad_model_folders(footsel, bumpy_map, model_folder):
    select = ("select", bumpy_map, *SELECT_POSE, "--model", model_folder)
    (model_folder / "hind.onnx").rename(model_folder / "gone")
    assert footsel(*select).complains("hind.onnx", "export")
    (model_folder / "hind.onnx").write_bytes(b"foreign")
    assert footsel(*select).complains("hind.onnx", "SHA-256")
    (model_folder / "SHA256SUMS").unlink()
    assert footsel(*select).complains("SHA256SUMS", "footsel export")
    assert footsel("select", bumpy_map, *SELECT_POSE, "--model", bumpy_map).complains("is a file")
