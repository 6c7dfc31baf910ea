"""Where a ball that is lowered straight down first touches a height field.

The surface is the one that PyBullet collides with: every quad of neighbouring cell centres is split along the diagonal
from (i + 1, j) to (i, j + 1).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.compiled import compiled

Array = NDArray[np.float64]


def touchdown_heights(heights: NDArray[np.floating], resolution: float, radius: float, xy: Array) -> Array:
    """(k,) height of the ball's centre at first touch, in [m].

    heights: (nx, ny) in [m], centred on the origin. radius: of the ball, in [m].
    xy: (k, 2) where the ball is lowered, at least a radius inside the outer cell centres, in [m].
    """
    surface = np.ascontiguousarray(heights, dtype=np.float64)
    index = xy / resolution + (np.array(surface.shape) - 1) / 2
    centres: Array = _touchdown_heights(surface / resolution, radius / resolution, np.ascontiguousarray(index))
    return centres * resolution


@compiled
def _touchdown_heights(surface: Array, radius: float, index: Array) -> Array:  # pragma: no cover - compiled
    """All lengths in cells."""
    centres = np.empty(len(index))
    for k in range(len(index)):
        x, y = index[k]
        highest = -np.inf
        for i in range(int(np.floor(x - radius)), int(np.floor(x + radius)) + 1):
            for j in range(int(np.floor(y - radius)), int(np.floor(y + radius)) + 1):
                corner = (i - x, j - y, surface[i, j])
                ahead = (i + 1 - x, j - y, surface[i + 1, j])
                left = (i - x, j + 1 - y, surface[i, j + 1])
                far = (i + 1 - x, j + 1 - y, surface[i + 1, j + 1])
                highest = max(highest, _over_face(corner, ahead, left, radius), _over_face(far, left, ahead, radius))
                # Each quad looks at its corner and the edges that leave it; its neighbours look at the others.
                highest = max(highest, _over_corner(corner, radius), _over_edge(ahead, left, radius))
                highest = max(highest, _over_edge(corner, ahead, radius), _over_edge(corner, left, radius))
        centres[k] = highest
    return centres


@compiled
def _over_corner(corner: Any, radius: float) -> float:  # pragma: no cover - compiled
    """Height of a ball on the vertical axis that touches a point; -inf if it passes by."""
    reach = radius**2 - corner[0] ** 2 - corner[1] ** 2
    return float(corner[2] + np.sqrt(reach)) if reach >= 0 else -np.inf


@compiled
def _over_edge(start: Any, end: Any, radius: float) -> float:  # pragma: no cover - compiled
    """The same for an edge: the axis' upper point at the ball's radius from the edge's line, if it faces the edge."""
    dx, dy, dz = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    dx, dy, dz = dx / length, dy / length, dz / length
    # With w from the line's start to the ball's centre, |w|^2 - (w . d)^2 = r^2 is quadratic in the centre's height.
    along = -(start[0] * dx + start[1] * dy)
    flat = start[0] ** 2 + start[1] ** 2
    a = 1 - dz * dz
    under_root = (along * dz) ** 2 - a * (flat - along**2 - radius**2)
    if under_root < 0:
        return -np.inf
    rise = (along * dz + np.sqrt(under_root)) / a
    at = along + rise * dz
    return float(start[2] + rise) if 0 <= at <= length else -np.inf


@compiled
def _over_face(corner: Any, first: Any, second: Any, radius: float) -> float:  # pragma: no cover - compiled
    """The same for a right-angled triangle whose two short sides leave `corner` along the grid's axes."""
    along_x, along_y = first[0] - corner[0], second[1] - corner[1]
    if along_x == 0:  # `first` lies along y.
        first, second = second, first
        along_x, along_y = first[0] - corner[0], second[1] - corner[1]
    slope_x, slope_y = (first[2] - corner[2]) / along_x, (second[2] - corner[2]) / along_y
    stretch = np.sqrt(1 + slope_x**2 + slope_y**2)
    # The ball touches the plane at its centre minus the normal times its radius.
    touch_x, touch_y = radius * slope_x / stretch, radius * slope_y / stretch
    u, v = (touch_x - corner[0]) / along_x, (touch_y - corner[1]) / along_y
    if u < 0 or v < 0 or u + v > 1:
        return -np.inf
    return float(corner[2] - slope_x * corner[0] - slope_y * corner[1] + radius * stretch)
