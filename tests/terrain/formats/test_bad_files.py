"""Every file that cannot be read is one MapError in one line that names the file."""

import sys

import numpy as np
import pytest
from PIL import Image
from plyfile import PlyData, PlyElement

from footsel import ElevationMap
from footsel.errors import MapError, MissingExtraError

OPTIONS = {"resolution": 0.1, "png_range": (0.0, 1.0)}
SUFFIXES = [".npz", ".png", ".bag", ".db3", ".mcap", ".pcd", ".ply"]


def refused(path, named="", **options):
    with pytest.raises(MapError) as caught:
        ElevationMap.load(path, **{**OPTIONS, **options})
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    assert caught.value.remedy
    assert named in message
    return message


@pytest.fixture
def good_file(tmp_path, write_bag, write_pcd, cloud):
    def write(suffix):
        return _good_file(tmp_path / f"map{suffix}", suffix, write_bag, write_pcd, cloud(0))

    return write


def _good_file(path, suffix, write_bag, write_pcd, points):
    rng = np.random.default_rng(0)
    if suffix == ".npz":
        ElevationMap(rng.random((30, 30)), 0.1).save(path)
    elif suffix == ".png":
        Image.fromarray(rng.integers(0, 255, (30, 30)).astype(np.uint8)).save(path)
    elif suffix == ".pcd":
        write_pcd(path, points, "binary_compressed")
    elif suffix == ".ply":
        vertices = np.array([tuple(p) for p in points], dtype=[("x", "f4"), ("y", "f4"), ("z", "f4")])
        PlyData([PlyElement.describe(vertices, "vertex")]).write(path)
    else:
        kind = {".bag": "ros1", ".db3": "sqlite3", ".mcap": "mcap"}[suffix]
        bag = write_bag(kind, lambda x, y: x + y, rows=30, columns=30, resolution=0.1)
        return bag if bag.is_file() else next(bag.glob(f"*{suffix}"))
    return path


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_that_is_missing(tmp_path, suffix):
    refused(tmp_path / f"nothing{suffix}", "no such file")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("content", [b"", b"nonsense\n" * 200, bytes(range(256)) * 20])
def test_a_file_of_another_format(tmp_path, suffix, content):
    path = tmp_path / f"map{suffix}"
    path.write_bytes(content)
    refused(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.9])
def test_a_file_that_was_cut_off(good_file, suffix, share):
    path = good_file(suffix)
    whole = path.read_bytes()
    assert ElevationMap.load(path, **OPTIONS).known.any()
    path.write_bytes(whole[: int(len(whole) * share)])
    refused(path)


def test_a_suffix_or_folder_that_cannot_be_read(tmp_path):
    (tmp_path / "map.tiff").touch()
    refused(tmp_path / "map.tiff", ".npz, .png, .bag")
    refused(tmp_path, "metadata.yaml")
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: [1")
    refused(tmp_path, "damaged")


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ({"heights": np.zeros((3, 3)), "resolution": 0.1}, "lacks elevation"),
        ({"elevation": np.zeros((3, 3))}, "lacks resolution"),
        ({"elevation": np.zeros(9), "resolution": 0.1}, "shape (9,)"),
        ({"elevation": np.zeros((3, 3)), "resolution": [0.1, 0.1]}, "resolution has shape (2,)"),
        ({"elevation": np.zeros((3, 3)), "resolution": 0.0}, "resolution is 0.0"),
        ({"elevation": np.zeros((3, 3)), "resolution": -1}, "resolution is -1.0"),
        ({"elevation": np.zeros((3, 3)), "resolution": "fine"}, "not numeric"),
        ({"elevation": np.full((3, 3), np.inf), "resolution": 0.1}, "infinite"),
        ({"elevation": np.full((3, 3), np.nan), "resolution": 0.1}, "no known cell"),
        ({"elevation": np.zeros((3, 3)), "resolution": 0.1, "position": [1, 2, 3]}, "position"),
        ({"elevation": np.zeros((3, 3), dtype=complex), "resolution": 0.1}, "complex"),
    ],
)
def test_npz_that_makes_no_sense(tmp_path, content, named):
    np.savez(tmp_path / "map.npz", **content)
    refused(tmp_path / "map.npz", named)


@pytest.mark.parametrize("resolution", [0.0, -0.1, np.nan])
@pytest.mark.parametrize("suffix", [".png", ".pcd", ".ply"])
def test_a_resolution_that_is_no_length(good_file, suffix, resolution):
    refused(good_file(suffix), "resolution is", resolution=resolution)


def test_a_bag_whose_last_map_is_unknown(write_bag):
    path = write_bag("ros1", lambda *_: np.nan, rows=3, columns=3, resolution=0.1)
    refused(path, "no known cell")


@pytest.mark.parametrize("header", ["FIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\n", "FIELDS x y z\nSIZE 4 4 4\n"])
def test_pcd_without_heights_or_with_half_a_header(tmp_path, header):
    (tmp_path / "map.pcd").write_text(f"VERSION 0.7\n{header}WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 2 3\n1 2 3\n")
    refused(tmp_path / "map.pcd")


def test_ply_without_heights(tmp_path):
    flat = np.array([(0, 0)], dtype=[("x", "f4"), ("y", "f4")])
    PlyData([PlyElement.describe(flat, "vertex")]).write(tmp_path / "map.ply")
    refused(tmp_path / "map.ply", "x, y and z")


@pytest.mark.parametrize(
    ("suffix", "module", "package"),
    [
        (".png", "PIL", "Pillow"),
        (".ply", "plyfile", "plyfile"),
        (".bag", "rosbags.highlevel", "rosbags"),
        (".mcap", "rosbags.highlevel", "rosbags"),
    ],
)
def test_a_package_that_is_not_installed_is_named_with_its_extra(good_file, monkeypatch, suffix, module, package):
    path = good_file(suffix)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtraError, match=rf"{package}.*footsel\[maps\]"):
        ElevationMap.load(path, **OPTIONS)
