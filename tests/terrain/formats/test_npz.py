import io
import pickle
import zipfile

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.errors import MapError


class Bomb:
    """Unpickling this fails the test."""

    def __reduce__(self):
        return pytest.fail, ("a pickled key was read",)


def test_a_saved_map_comes_back(tmp_path):
    elevation = np.random.default_rng(0).normal(size=(7, 9)).astype(np.float32)
    elevation[2, 3] = np.nan
    ElevationMap(elevation, 0.033, np.array([1.5, -2.25])).save(tmp_path / "map.npz")
    again = ElevationMap.load(tmp_path / "map.npz")
    np.testing.assert_array_equal(again.elevation, elevation)
    assert again.resolution == 0.033
    assert again.position.tolist() == [1.5, -2.25]


def test_other_keys_are_never_read(tmp_path):
    path = tmp_path / "map.npz"
    np.savez(path, elevation=np.ones((3, 4)), resolution=0.02, source="somewhere")
    with zipfile.ZipFile(path, "a") as archive:
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(header, {"descr": "|O", "fortran_order": False, "shape": ()})
        archive.writestr("bomb.npy", header.getvalue() + pickle.dumps(Bomb()))
    assert ElevationMap.load(path).shape == (3, 4)


def test_a_pickled_elevation_is_refused(tmp_path):
    np.savez(tmp_path / "map.npz", elevation=np.array([[Bomb(), 1], [1, 1]], dtype=object), resolution=0.02)
    with pytest.raises(MapError, match=r"map\.npz.*damaged"):
        ElevationMap.load(tmp_path / "map.npz")


def test_position_defaults_to_the_origin(tmp_path):
    np.savez(tmp_path / "map.npz", elevation=np.ones((3, 4)), resolution=[0.02])
    assert ElevationMap.load(tmp_path / "map.npz").position.tolist() == [0, 0]


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "map.npz"
    ElevationMap(np.zeros((2, 2)), 0.02).save(path)
    before = path.read_bytes()

    def disk_full(file, **_):
        file.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", disk_full)
    with pytest.raises(MapError, match="No space left"):
        ElevationMap(np.ones((2, 2)), 0.02).save(path)
    assert [file.name for file in tmp_path.iterdir()] == ["map.npz"]
    assert path.read_bytes() == before


def test_a_folder_that_does_not_exist_is_named(tmp_path):
    with pytest.raises(MapError, match="nowhere"):
        ElevationMap(np.zeros((2, 2)), 0.02).save(tmp_path / "nowhere" / "map.npz")
