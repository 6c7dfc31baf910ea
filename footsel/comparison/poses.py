"""Where the base stands when selectors are compared: drawn by a seed, on ground that is known."""

import numpy as np

from footsel.errors import MapError
from footsel.footholds import BasePose, LegLayout
from footsel.terrain import ElevationMap

#: Roll and pitch lie within this. [rad]
TILT = float(np.deg2rad(10.0))
#: Height of ANYmal B's base above the ground that its feet would stand on; other robots scale it. [m]
HEIGHTS = (0.38, 0.55)
#: Standing height that goes with HEIGHTS, that of ANYmal B's description. [m]
REFERENCE_STANDING_HEIGHT = 0.4880972592457825
#: Draws without known ground in a row, after which a map is taken to have none.
MOST_DRAWS = 1000


def draw_poses(rng: np.random.Generator, elevation_map: ElevationMap, layout: LegLayout, count: int) -> list[BasePose]:
    """`count` base poses: anywhere on the map's known cells, any yaw, tilt within TILT, heights within HEIGHTS.

    The height counts from the median known ground under the rectangle of the nominal feet. Poses without such ground
    are drawn again. Raises MapError if there are no others.
    """
    cells = np.argwhere(elevation_map.known)
    x, y = elevation_map.x(), elevation_map.y()
    scale = layout.standing_height / REFERENCE_STANDING_HEIGHT
    poses: list[BasePose] = []
    draws = 0
    while len(poses) < count:
        if draws == MOST_DRAWS or not len(cells):
            raise MapError("has no place with known ground under the robot's feet", "give a map that has seen ground")
        draws += 1
        i, j = cells[rng.integers(len(cells))]
        # Just inside the cell's border, where rounding cannot move the base to a neighbour.
        within = rng.uniform(-0.499, 0.499, 2) * elevation_map.resolution
        yaw = rng.uniform(-np.pi, np.pi)
        roll, pitch = rng.uniform(-TILT, TILT, 2)
        height = rng.uniform(*HEIGHTS) * scale
        place = (float(x[i] + within[0]), float(y[j] + within[1]))
        ground = layout.ground_height(elevation_map, *place, yaw)
        if not np.isnan(ground):
            poses.append(BasePose(*place, float(ground + height), float(roll), float(pitch), float(yaw)))
            draws = 0
    return poses
