"""Writers of map files for the tests, each from its format's own conventions, cell by cell."""

import sqlite3
import struct
from pathlib import Path

import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from footsel.terrain.formats.grid_map_bag import DEFINITIONS, GRID_MAP, grid_map_types


def _ros1_types():
    """In ROS 1 the header is part of GridMapInfo."""
    types = get_typestore(Stores.ROS1_NOETIC)
    info, grid_map = DEFINITIONS.values()
    types.register(get_types_from_msg("std_msgs/Header header\n" + info, "grid_map_msgs/msg/GridMapInfo"))
    types.register(get_types_from_msg(grid_map.removeprefix("std_msgs/Header header\n"), GRID_MAP))
    return types


def _grid_map(types, height_at, *, rows, columns, resolution, position=(0.0, 0.0), start=(0, 0), row_major=False,
             layers=("elevation",), quaternion=(0.0, 0.0, 0.0, 1.0)):  # fmt: skip
    """A GridMap message whose cells hold `height_at(x, y)` of their own centre in the world."""
    t = types.types
    matrix = np.empty((rows, columns), dtype=np.float32)
    for row in range(rows):
        for column in range(columns):
            # Cells count from the +x, +y corner; the buffer starts at the start index.
            away_x, away_y = (row - start[0]) % rows, (column - start[1]) % columns
            x = position[0] + (rows / 2 - away_x - 0.5) * resolution
            y = position[1] + (columns / 2 - away_y - 0.5) * resolution
            matrix[row, column] = height_at(x, y)
    dimensions = [("row_index", rows, rows * columns), ("column_index", columns, columns)]
    if not row_major:
        dimensions = [("column_index", columns, rows * columns), ("row_index", rows, rows)]
    dim = [t["std_msgs/msg/MultiArrayDimension"](label=a, size=b, stride=c) for a, b, c in dimensions]
    values = matrix.ravel(order="C" if row_major else "F")
    layout = t["std_msgs/msg/MultiArrayLayout"](dim=dim, data_offset=0)
    time = t["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    ros1 = "seq" in t["std_msgs/msg/Header"].__dataclass_fields__
    header = t["std_msgs/msg/Header"](**({"seq": 0} if ros1 else {}), stamp=time, frame_id="map")
    pose = t["geometry_msgs/msg/Pose"](
        position=t["geometry_msgs/msg/Point"](x=position[0], y=position[1], z=0.0),
        orientation=t["geometry_msgs/msg/Quaternion"](**dict(zip("xyzw", quaternion, strict=True))),
    )
    info = {
        "resolution": resolution,
        "length_x": rows * resolution,
        "length_y": columns * resolution,
        "pose": pose,
    }
    info = t["grid_map_msgs/msg/GridMapInfo"](**info, **({"header": header} if ros1 else {}))
    offsets = range(len(layers))
    return t[GRID_MAP](
        **({} if ros1 else {"header": header}),
        info=info,
        layers=list(layers),
        basic_layers=[],
        data=[t["std_msgs/msg/Float32MultiArray"](layout=layout, data=values + np.float32(k)) for k in offsets],
        outer_start_index=start[0],
        inner_start_index=start[1],
    )


def _write_bag(folder: Path, kind: str, height_at, topics=("/map",), **options) -> Path:
    """A bag of a kind (ros1, sqlite3, mcap, undefined = sqlite3 without definitions), and the path to load it from.

    Each topic gets one message at the height of the sea, then the map; later topics lie 10 m higher each.
    """
    types = _ros1_types() if kind == "ros1" else grid_map_types()
    path = folder / ("map.bag" if kind == "ros1" else "map")
    if kind == "ros1":
        writer = rosbag1.Writer(path)
    else:
        storage = rosbag2.StoragePlugin.MCAP if kind == "mcap" else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(path, version=8, storage_plugin=storage)
    serialize = types.serialize_ros1 if kind == "ros1" else types.serialize_cdr
    with writer:
        for number, topic in enumerate(topics):
            connection = writer.add_connection(topic, GRID_MAP, typestore=types)
            sea = _grid_map(types, lambda *_: 0.0, **options)
            land = _grid_map(types, lambda x, y, lift=10 * number: height_at(x, y) + lift, **options)
            writer.write(connection, 1_000_000_000, serialize(sea, GRID_MAP))
            writer.write(connection, 2_000_000_000, serialize(land, GRID_MAP))
    if kind == "undefined":
        with sqlite3.connect(next(path.glob("*.db3"))) as database:
            database.execute("DELETE FROM message_definitions")
    return path


def _compress_lzf(data):
    """Greedy LZF with a table of the last place of every three bytes, to test unpacking with real copies."""
    packed, literals, seen, at = bytearray(), bytearray(), {}, 0

    def flush():
        for start in range(0, len(literals), 32):
            packed.append(len(literals[start : start + 32]) - 1)
            packed.extend(literals[start : start + 32])
        literals.clear()

    while at < len(data):
        before = seen.get(data[at : at + 3], -1)
        seen[data[at : at + 3]] = at
        length = 0
        if before >= 0 and at - before <= 8192:
            while at + length < len(data) and length < 264 and data[before + length] == data[at + length]:
                length += 1
        if length < 3:
            literals.append(data[at])
            at += 1
            continue
        flush()
        distance, rest = at - before - 1, length - 2
        packed.append(min(rest, 7) << 5 | distance >> 8)
        if rest >= 7:
            packed.append(rest - 7)
        packed.append(distance & 255)
        at += length
    flush()
    return bytes(packed)


def _write_pcd(path, points, encoding):
    """A cloud with an intensity before x and padding between y and z, as drivers write them."""
    n = len(points)
    header = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS intensity x y _ z\nSIZE 2 4 4 1 8\nTYPE U F F U F\nCOUNT 1 1 1 3 1\n"
        f"WIDTH {n}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA {encoding}\n"
    ).encode()
    x, y, z = points.T
    fields = np.full(n, 7, "<u2"), x.astype("<f4"), y.astype("<f4"), np.zeros((n, 3), "u1"), z.astype("<f8")
    if encoding == "ascii":
        body = "".join(f"7 {float(a)!r} {float(b)!r} 0 0 0 {float(c)!r}\n" for a, b, c in points).encode()
    elif encoding == "binary":
        body = b"".join(b"".join(field[k].tobytes() for field in fields) for k in range(n))
    else:
        apart = b"".join(field.tobytes() for field in fields)
        packed = _compress_lzf(apart)
        body = struct.pack("<II", len(packed), len(apart)) + packed
    path.write_bytes(header + body)


def _cloud(seed):
    """One to four points in every cell of a 5 cm grid of 12x9 cells at (1, -2), rounded to what float32 holds."""
    rng = np.random.default_rng(seed)
    points = []
    for i in range(12):
        for j in range(9):
            inside = rng.uniform(0.1, 0.9, (rng.integers(1, 5), 2))
            xy = (inside + np.array([i, j])) * 0.05 + np.array([1, -2])
            points += [(*place, height) for place, height in zip(xy, rng.normal(size=len(xy)), strict=True)]
    return np.array(points).astype(np.float32).astype(float)


@pytest.fixture
def ros1_types():
    return _ros1_types()


@pytest.fixture
def write_bag(tmp_path):
    def write(kind, height_at, **options):
        return _write_bag(tmp_path, kind, height_at, **options)

    return write


@pytest.fixture
def write_pcd():
    return _write_pcd


@pytest.fixture
def compress_lzf():
    return _compress_lzf


@pytest.fixture
def cloud():
    return _cloud
