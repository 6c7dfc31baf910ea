"""footsel on maps in grid_map's convention, from numpy arrays, without ROS: copy this file beside your node.

grid_map keeps a layer as a matrix whose cell (0, 0) lies at the +x, +y corner, rows toward -x and columns toward -y, as
a circular buffer that begins at `start_index`. An ElevationMap has cell (0, 0) at the -x, -y corner.

    from grid_map import footholds_on_grid_map

    layer = np.array(message.data[k].data).reshape(columns, rows).T    # grid_map_msgs stores columns one by one
    footholds = footholds_on_grid_map(
        selector, layer, message.info.resolution,
        (message.info.pose.position.x, message.info.pose.position.y),
        (message.outer_start_index, message.inner_start_index), base_pose,
    )
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from footsel import ElevationMap
from footsel.errors import MapError
from footsel.footholds import Foothold
from footsel.runtime import FootholdSelector


def elevation_map_of(
    layer: ArrayLike, resolution: float, position: ArrayLike = (0.0, 0.0), start_index: tuple[int, int] = (0, 0)
) -> ElevationMap:
    """One layer of a grid map as an ElevationMap.

    layer: (rows, columns) heights as the buffer holds them, NaN = unknown, in [m].
    resolution: side of a cell; position: (2,) centre of the map in its frame, in [m].
    start_index: (outer, inner), row and column of the buffer where the map begins.

    Raises MapError for a layer that is not two-dimensional and for a start index outside of it.
    """
    heights = np.asarray(layer, dtype=np.float32)
    if heights.ndim != 2:
        raise MapError(f"layer has shape {heights.shape}", "expected (rows, columns)")
    if not all(0 <= first < cells for first, cells in zip(start_index, heights.shape, strict=True)):
        raise MapError(f"start index {tuple(start_index)} is outside of {heights.shape} cells", "check the message")
    unrolled = np.roll(heights, (-start_index[0], -start_index[1]), axis=(0, 1))
    return ElevationMap(unrolled[::-1, ::-1], resolution, np.asarray(position, dtype=np.float64))


def footholds_on_grid_map(
    selector: FootholdSelector,
    layer: ArrayLike,
    resolution: float,
    position: ArrayLike,
    start_index: tuple[int, int],
    base_pose: ArrayLike,
    **options: Any,
) -> dict[str, Foothold]:
    """Footholds of each leg in the map's frame.

    layer, resolution, position, start_index: as in `elevation_map_of`. base_pose: x, y, z, roll, pitch, yaw of the base
    in the map's frame, in [m] and [rad]. options: of FootholdSelector.select.
    """
    return selector.select(elevation_map_of(layer, resolution, position, start_index), base_pose, **options)
