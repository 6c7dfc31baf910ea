import numpy as np
import pytest
from plyfile import PlyData, PlyElement

from footsel import ElevationMap
from footsel.errors import MapError
from footsel.terrain.formats.pcd import decompress_lzf
from footsel.terrain.formats.point_cloud import grid_points


def highest_by_hand(points):
    elevation = np.full((12, 9), -np.inf)
    for x, y, z in points:
        i, j = int((x - 1) / 0.05), int((y + 2) / 0.05)
        elevation[i, j] = max(elevation[i, j], z)
    return elevation


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
def test_pcd_gives_the_highest_point_of_each_cell(tmp_path, write_pcd, cloud, encoding):
    points = cloud(0)
    write_pcd(tmp_path / "cloud.pcd", points, encoding)
    terrain = ElevationMap.load(tmp_path / "cloud.pcd", resolution=0.05)
    np.testing.assert_allclose(terrain.elevation, highest_by_hand(points), atol=1e-6)
    assert terrain.position == pytest.approx([1.3, -1.775])


@pytest.mark.parametrize("text", [False, True])
def test_ply_gives_the_highest_point_of_each_cell(tmp_path, cloud, text):
    points = cloud(1)
    vertices = np.array([(9, *p) for p in points], dtype=[("c", "u1"), ("x", "f4"), ("y", "f4"), ("z", "f8")])
    PlyData([PlyElement.describe(vertices, "vertex")], text=text).write(tmp_path / "cloud.ply")
    terrain = ElevationMap.load(tmp_path / "cloud.ply", resolution=0.05)
    np.testing.assert_allclose(terrain.elevation, highest_by_hand(points), atol=1e-6)


def test_cells_without_a_point_are_unknown_and_points_without_a_height_do_not_count():
    terrain = grid_points(np.array([[0.0, 0.0, 1.0], [0.31, 0.21, 2.0], [0.1, 0.1, np.nan], [9, 9, np.inf]]), 0.1)
    assert terrain.shape == (4, 3)
    assert terrain.known.sum() == 2


def test_one_flying_point_over_a_well_seen_cell_does_not_raise_it():
    ground = np.column_stack([np.full((30, 2), 0.05), np.linspace(0, 0.01, 30)])
    corner = [[0.15, 0.15, 0.0]]
    flying = [[0.05, 0.05, 1.5]]
    terrain = grid_points(np.concatenate([ground, corner, flying]), 0.1)
    assert terrain.elevation[0, 0] == pytest.approx(0.009, abs=0.001)


def test_the_default_cell_is_2_cm(tmp_path, write_pcd, cloud):
    write_pcd(tmp_path / "cloud.pcd", cloud(0), "binary")
    assert ElevationMap.load(tmp_path / "cloud.pcd").resolution == 0.02


def test_a_stray_point_far_away_is_told_before_memory_runs_out():
    with pytest.raises(MapError, match="spans"):
        grid_points(np.array([[0, 0, 0], [1e6, 1e6, 0.0]]), 0.02)


@pytest.mark.parametrize("data", [b"", b"abc", bytes(1000), bytes(range(256)) * 40, b"abcabcabcabcabcd" * 90])
def test_lzf_unpacks_what_was_packed(compress_lzf, data):
    assert decompress_lzf(compress_lzf(data), len(data)) == data


def test_lzf_copies_may_overlap_what_they_write():
    # Literal "ab", then copy nine bytes from two back: length 7 + 0 further + 2.
    assert decompress_lzf(bytes([1]) + b"ab" + bytes([7 << 5, 0, 1]), 11) == b"abababababa"


@pytest.mark.parametrize("packed", [bytes([32, 5]), bytes([5]) + b"ab", bytes([0, 65, 7 << 5])])
def test_damaged_lzf_is_refused(packed):
    with pytest.raises((ValueError, IndexError)):
        decompress_lzf(packed, 100)
