"""`grid_map_msgs/GridMap` in ROS 1 bags and ROS 2 bags, read without ROS.

grid_map keeps a layer as a matrix whose cell (0, 0) lies at the +x, +y corner, rows toward -x and columns toward -y.
The matrix is a circular buffer: the row that comes first is `outer_start_index`, the column `inner_start_index`.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from footsel.errors import MapError
from footsel.terrain.elevation_map import ElevationMap
from footsel.terrain.formats.decoding import decoding

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

GRID_MAP = "grid_map_msgs/msg/GridMap"
#: ROS 2 definitions (docs.ros.org, package grid_map_msgs), for bags that carry none, as those from before Iron.
DEFINITIONS = {
    "grid_map_msgs/msg/GridMapInfo": (
        "float64 resolution\nfloat64 length_x\nfloat64 length_y\ngeometry_msgs/Pose pose\n"
    ),
    GRID_MAP: (
        "std_msgs/Header header\ngrid_map_msgs/GridMapInfo info\nstring[] layers\nstring[] basic_layers\n"
        "std_msgs/Float32MultiArray[] data\nuint16 outer_start_index\nuint16 inner_start_index\n"
    ),
}


def load(path: Path, layer: str) -> ElevationMap:
    """The last GridMap of a bag; of several topics that have the layer, the first by name."""
    messages = _last_grid_maps(path)
    for message in messages:
        if layer in message.layers:
            return _to_elevation_map(message, layer)
    layers = dict.fromkeys(name for message in messages for name in message.layers)
    raise MapError(f"has no layer {layer!r}", f"choose from (--layer): {', '.join(layers) or 'none, the map is empty'}")


def grid_map_types() -> "Typestore":
    """Message types of ROS 2 with grid_map's."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE)
    for name, definition in DEFINITIONS.items():
        types.register(get_types_from_msg(definition, name))
    return types


def _last_grid_maps(path: Path) -> list[Any]:
    """The last GridMap message of every topic that has one, by topic name."""
    with decoding("ROS bag", package="rosbags"):
        from rosbags.highlevel import AnyReader

        with AnyReader([path], default_typestore=grid_map_types()) as reader:
            connections = [connection for connection in reader.connections if connection.msgtype == GRID_MAP]
            # An empty list of connections would mean all of them.
            last = {c.topic: raw for c, _, raw in reader.messages(connections)} if connections else {}
            messages = [reader.deserialize(last[topic], GRID_MAP) for topic in sorted(last)]
            found = sorted({connection.msgtype for connection in reader.connections})
    if not messages:
        raise MapError("holds no GridMap message", f"found: {', '.join(found) or 'nothing'}")
    return messages


def _to_elevation_map(message: Any, layer: str) -> ElevationMap:
    info = message.info
    if len(message.data) != len(message.layers):
        raise MapError(f"has {len(message.layers)} layers and {len(message.data)} arrays", "the bag is damaged")
    matrix = _to_matrix(message.data[message.layers.index(layer)])
    lengths = np.array([info.length_x, info.length_y])
    if not np.allclose(np.array(matrix.shape) * info.resolution, lengths, rtol=0, atol=abs(info.resolution) / 2):
        raise MapError(
            f"layer {layer!r} has {matrix.shape} cells of {info.resolution} m",
            f"its lengths say {lengths.tolist()} m: the bag is damaged",
        )
    turn = info.pose.orientation
    # An orientation that was never set is all zeros.
    if max(abs(turn.x), abs(turn.y), abs(turn.z)) > 1e-3:
        quaternion = tuple(round(value, 3) for value in (turn.x, turn.y, turn.z, turn.w))
        raise MapError(f"is rotated in its frame (xyzw {quaternion})", "record a map that is aligned with its frame")
    first = (message.outer_start_index, message.inner_start_index)
    unrolled = np.roll(matrix, (-first[0], -first[1]), axis=(0, 1))
    return ElevationMap(unrolled[::-1, ::-1], info.resolution, np.array([info.pose.position.x, info.pose.position.y]))


def _to_matrix(array: Any) -> NDArray[np.float32]:
    """(rows, columns) of a Float32MultiArray; its labels say whether columns (Eigen's default) or rows come first."""
    dimensions = {dimension.label: dimension.size for dimension in array.layout.dim}
    labels = tuple(dimensions)
    if labels not in {("column_index", "row_index"), ("row_index", "column_index")}:
        raise MapError(f"layer has dimensions {labels}", "expected column_index and row_index")
    outer, inner = dimensions.values()
    values = array.data[array.layout.data_offset :]
    if values.size != outer * inner:
        raise MapError(f"layer has {values.size} values", f"expected {outer} x {inner}; the bag is damaged")
    matrix = np.asarray(values, dtype=np.float32).reshape(outer, inner)
    return matrix.T if labels[0] == "column_index" else matrix
