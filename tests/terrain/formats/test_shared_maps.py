"""Maps recorded by others, in the formats that users hold. They lie beside the repository and are no part of it."""

from pathlib import Path

import numpy as np
import pytest

from footsel import ElevationMap

MAPS = Path(__file__).resolve().parents[4] / "shared" / "maps"

pytestmark = pytest.mark.skipif(not MAPS.is_dir(), reason=f"the maps of others are not at {MAPS}")


def test_all_npz_load():
    paths = sorted(MAPS.glob("*.npz"))
    assert len(paths) >= 10
    for path in paths:
        assert ElevationMap.load(path).known.mean() > 0.4


def test_bag_of_eth_equals_its_published_map():
    bag = ElevationMap.load(MAPS / "raw" / "elevation_map.bag")
    published = ElevationMap.load(MAPS / "made_traversability_bag.npz")
    np.testing.assert_array_equal(bag.elevation, published.elevation)
    slope = ElevationMap.load(MAPS / "raw" / "elevation_map.bag", layer="traversability_slope")
    assert not np.array_equal(slope.elevation, bag.elevation, equal_nan=True)


def test_bag_with_holes_keeps_them():
    assert ElevationMap.load(MAPS / "raw" / "grid_map.bag").known.mean() == pytest.approx(0.19, abs=0.01)


def test_picture_of_grid_maps_demo_lies_as_its_published_map():
    picture = ElevationMap.load(MAPS / "raw" / "terrain.png", resolution=0.02, png_range=(-0.5, 1.0))
    published = ElevationMap.load(MAPS / "made_gridmap_terrain_10m.npz")
    np.testing.assert_allclose(picture.elevation, published.elevation, atol=1e-6)


def test_clouds_give_ground_and_what_stands_on_it():
    steps = ElevationMap.load(MAPS / "raw" / "tilted-steps.pcd")
    assert steps.resolution == 0.02
    assert 0.2 < steps.known.mean() < 0.4
    assert abs(np.nanmedian(steps.elevation)) < 0.1
    maze = ElevationMap.load(MAPS / "raw" / "em_maze.ply", resolution=0.05)
    assert maze.known.mean() > 0.6
    assert np.nanmax(maze.elevation) == pytest.approx(1.05, abs=0.1)
