import numpy as np
import pytest

from footsel import ElevationMap
from footsel.errors import MapError
from footsel.terrain import LocalMap, extract_local_map, extract_local_map_as_paper
from footsel.terrain.local_map import cell_offsets

EXTRACTORS = [extract_local_map, extract_local_map_as_paper]
YAWS = [0.0, 0.3, np.pi / 4, 1.9, -2.6, np.pi]


def random_map(seed, cells=150, resolution=0.02, holes=0.15):
    rng = np.random.default_rng(seed)
    elevation = rng.uniform(-0.5, 0.1, (cells, cells))
    elevation[rng.random(elevation.shape) < holes] = np.nan
    return ElevationMap(elevation, resolution, np.array([0.7, -1.3]))


def world_xy(hip, yaw, resolution=0.02):
    """(40, 40, 2) cell centres in the world, one at a time."""
    xy = np.empty((40, 40, 2))
    for i in range(40):
        for j in range(40):
            x, y = (i - 19.5) * resolution, (j - 19.5) * resolution
            xy[i, j] = hip[0] + np.cos(yaw) * x - np.sin(yaw) * y, hip[1] + np.sin(yaw) * x + np.cos(yaw) * y
    return xy


def test_cell_offsets_are_centred_on_the_point_below_the_hip():
    offsets = cell_offsets(40, 0.02)
    assert offsets[0, 39] == pytest.approx([-0.39, 0.39])
    assert offsets[20, 19] == pytest.approx([0.01, -0.01])


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("resolution", [0.01, 0.02, 0.033, 0.05])
@pytest.mark.parametrize("extract", EXTRACTORS)
def test_a_plane_stays_that_plane_at_any_yaw_and_cell_size(extract, resolution, yaw):
    n = round(4 / resolution)
    flat = ElevationMap(np.zeros((n, n)), resolution)
    x, y = np.meshgrid(flat.x(), flat.y(), indexing="ij")
    plane = ElevationMap(0.1 + 0.3 * x - 0.2 * y, resolution)
    hip = np.array([0.31, -0.17, 0.5])
    local = extract(plane, hip, yaw, 0.02)
    xy = world_xy(hip, yaw)
    expected = 0.1 + 0.3 * xy[..., 0] - 0.2 * xy[..., 1] - hip[2]
    # The outer half cell of the paper's window has no neighbour to lean on.
    inner = (np.abs(xy - hip[:2]) < 0.51 - resolution).all(axis=-1) if extract is extract_local_map_as_paper else True
    np.testing.assert_allclose(np.where(inner, local.heights, 0), np.where(inner, expected, 0), atol=1e-5)
    np.testing.assert_allclose(local.positions()[..., :2], xy, atol=1e-12)


@pytest.mark.parametrize("yaw", YAWS)
@pytest.mark.parametrize("resolution", [0.02, 0.033])
def test_a_cell_is_unknown_exactly_where_its_nearest_world_cell_is(yaw, resolution):
    world = random_map(0, resolution=resolution)
    hip = np.array([0.413, -1.127, 0.45])
    local = extract_local_map(world, hip, yaw, 0.02)
    i, j = np.moveaxis(np.rint(world.fractional_index(world_xy(hip, yaw))).astype(int), -1, 0)
    np.testing.assert_array_equal(local.known, ~np.isnan(world.elevation[i, j]))


def test_the_part_beyond_the_map_is_unknown():
    world = random_map(1, holes=0)
    hip = np.array([world.x()[-1], world.position[1], 0.0])
    known = extract_local_map(world, hip, 0.0, 0.02).known
    assert known[:19].all()
    assert not known[21:].any()


@pytest.mark.parametrize("yaw", [0.2, np.pi / 4, 2.4, -0.9])
def test_the_papers_way_equals_direct_sampling_but_for_its_corners(yaw):
    world = random_map(2, holes=0.05)
    hip = np.array([0.52, -1.41, 0.48])
    direct, paper = (extract(world, hip, yaw, 0.02) for extract in EXTRACTORS)
    lost = direct.known & ~paper.known
    assert not (paper.known & ~direct.known).any()
    # Cells inside the window by a full cell are the same; all that is lost lies near the corners.
    middle = world.window(hip[:2], 51).position
    inside = (np.abs(world_xy(hip, yaw) - middle) < 24.9 * 0.02).all(axis=-1)
    np.testing.assert_array_equal(direct.heights[inside], paper.heights[inside])
    corner = np.linalg.norm(cell_offsets(40, 0.02), axis=-1) > 0.49
    assert not (lost & ~corner).any()
    assert lost.sum() < 40


def test_the_papers_way_loses_cells_at_45_degrees_and_none_at_0():
    world = random_map(3, holes=0)
    hip = np.array([0.5, -1.4, 0.48])
    lost = {yaw: (~extract_local_map_as_paper(world, hip, np.deg2rad(yaw), 0.02).known).sum() for yaw in (0, 45)}
    assert lost[0] == 0
    assert lost[45] > 4


def test_turning_by_90_degrees_turns_the_map_by_90_degrees():
    world = random_map(4)
    hip = np.array([0.537, -1.391, 0.5])
    ahead = extract_local_map(world, hip, 0.4, 0.02).heights
    turned = extract_local_map(world, hip, 0.4 + np.pi / 2, 0.02).heights
    np.testing.assert_allclose(turned, np.rot90(ahead, -1), atol=1e-6)


def test_distances_are_horizontal_and_in_the_world():
    hip = np.array([1.0, 2.0, 0.5])
    local = LocalMap(np.zeros((40, 40)), 0.02, hip, 0.8)
    target = np.array([1.1, 1.8])
    expected = np.linalg.norm(world_xy(hip, 0.8) - target, axis=-1)
    np.testing.assert_allclose(local.distances_to(target), expected, atol=1e-12)


def test_heights_are_relative_to_the_hip():
    world = ElevationMap(np.full((100, 100), 0.3), 0.02)
    local = extract_local_map(world, [0, 0, 0.8], 0.0, 0.02)
    np.testing.assert_allclose(local.heights, -0.5, atol=1e-6)
    np.testing.assert_allclose(local.positions()[..., 2], 0.3, atol=1e-6)


@pytest.mark.parametrize(
    ("heights", "hip", "named"),
    [
        (np.zeros((4, 5)), np.zeros(3), r"\(4, 5\)"),
        (np.zeros((4, 4)), np.zeros(2), r"\(2,\)"),
        (np.full((4, 4), np.inf), np.zeros(3), "inf"),
    ],
)
def test_local_maps_that_make_no_sense_are_refused(heights, hip, named):
    with pytest.raises(MapError, match=named):
        LocalMap(heights, 0.02, hip, 0.0)
