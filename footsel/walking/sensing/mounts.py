"""Where the depth cameras sit on ANYmal B.

Its description has none: they are assumed to sit as the front and rear cameras of ANYmal C do, whose description puts
the front one at (0.484, 0.018, -0.042) in the base frame, 30 degrees down, and the rear one half a turn from it.
"""

import numpy as np
from numpy.typing import NDArray

POSITION = np.array([0.484, 0.018, -0.042])
PITCH = float(np.deg2rad(30.0))


def _mount(turns: int) -> NDArray[np.float64]:
    """(4, 4) placement of a camera's frame (x right, y down, z ahead) in B, after so many half turns about z."""
    ahead = np.array([np.cos(PITCH), 0.0, -np.sin(PITCH)])
    right = np.array([0.0, -1.0, 0.0])
    turn = np.diag([(-1.0) ** turns, (-1.0) ** turns, 1.0])
    placement = np.eye(4)
    placement[:3, :3] = turn @ np.column_stack([right, np.cross(ahead, right), ahead])
    placement[:3, 3] = turn @ POSITION
    return placement


FRONT, REAR = _mount(0), _mount(1)
