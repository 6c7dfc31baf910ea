import numpy as np
import pytest
from rosbags import rosbag1

from footsel import ElevationMap
from footsel.errors import MapError

KINDS = ["ros1", "sqlite3", "mcap", "undefined"]
GRID = {"rows": 5, "columns": 8, "resolution": 0.25, "position": (3.0, -2.0)}


def hillside(x, y):
    return 2 * x - 0.3 * y + 0.1 * np.sin(9 * x * y)


def assert_is_hillside(terrain, lift=0.0):
    assert terrain.shape == (5, 8)
    assert terrain.resolution == 0.25
    assert terrain.position.tolist() == [3.0, -2.0]
    x, y = np.meshgrid(terrain.x(), terrain.y(), indexing="ij")
    np.testing.assert_allclose(terrain.elevation, hillside(x, y) + lift, atol=1e-5)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("start", [(0, 0), (3, 0), (0, 5), (4, 7)])
def test_every_cell_lies_where_grid_map_puts_it(write_bag, kind, start):
    path = write_bag(kind, hillside, start=start, **GRID)
    assert_is_hillside(ElevationMap.load(path))


@pytest.mark.parametrize("kind", ["ros1", "sqlite3"])
def test_row_major_layers_say_so_in_their_labels(write_bag, kind):
    path = write_bag(kind, hillside, start=(2, 3), row_major=True, **GRID)
    assert_is_hillside(ElevationMap.load(path))


@pytest.mark.parametrize(("kind", "suffix"), [("sqlite3", "db3"), ("mcap", "mcap")])
def test_the_file_of_a_ros_2_bag_alone_is_enough(write_bag, kind, suffix):
    folder = write_bag(kind, hillside, **GRID)
    assert_is_hillside(ElevationMap.load(next(folder.glob(f"*.{suffix}"))))


def test_unknown_cells_stay_unknown(write_bag):
    path = write_bag("ros1", lambda x, _: np.nan if x > 3 else 1.0, **GRID)
    assert ElevationMap.load(path).known.sum() == 3 * 8


def test_layers_are_chosen_by_name(write_bag):
    path = write_bag("ros1", hillside, layers=("elevation", "smooth"), **GRID)
    assert_is_hillside(ElevationMap.load(path, layer="smooth"), lift=1.0)
    with pytest.raises(MapError, match=r"no layer 'colour'.*elevation, smooth"):
        ElevationMap.load(path, layer="colour")


def test_of_several_topics_the_first_by_name_is_read(write_bag):
    path = write_bag("sqlite3", hillside, topics=("/raw", "/elevation_map"), **GRID)
    assert_is_hillside(ElevationMap.load(path), lift=10.0)


def test_a_map_that_is_turned_in_its_frame_is_refused(write_bag):
    path = write_bag("ros1", hillside, quaternion=(0.0, 0.0, 0.6, 0.8), **GRID)
    with pytest.raises(MapError, match="rotated"):
        ElevationMap.load(path)


def test_an_orientation_that_was_never_set_is_none(write_bag):
    assert_is_hillside(ElevationMap.load(write_bag("ros1", hillside, quaternion=(0.0,) * 4, **GRID)))


def test_a_bag_without_a_grid_map_says_what_it_holds(tmp_path, ros1_types):
    types = ros1_types
    text = types.types["std_msgs/msg/String"](data="hello")
    with rosbag1.Writer(tmp_path / "map.bag") as writer:
        connection = writer.add_connection("/chatter", "std_msgs/msg/String", typestore=types)
        writer.write(connection, 1, types.serialize_ros1(text, "std_msgs/msg/String"))
    with pytest.raises(MapError, match=r"no GridMap.*std_msgs/msg/String"):
        ElevationMap.load(tmp_path / "map.bag")
