"""The ground of a simulated world: a height field that PyBullet collides with."""

import numpy as np
from numpy.typing import NDArray

from footsel.walking.bullet import BulletWorld, pybullet


def make_ground(
    client: BulletWorld, heights: NDArray[np.floating], resolution: float, position: NDArray[np.float64]
) -> int:
    """Body id of a height field whose vertices are the cell centres of a map.

    heights: (nx, ny) without unknown cells, in [m]. resolution: side of a cell, in [m].
    position: (2,) world xy of the map's centre, in [m].

    Every quad of neighbouring vertices is split along the diagonal from (i + 1, j) to (i, j + 1).
    """
    # The middle of the height range as Bullet computes it, in single precision.
    single = np.asarray(heights, dtype=np.float32)
    rows, columns = single.shape
    shape = client.createCollisionShape(
        pybullet.GEOM_HEIGHTFIELD,
        meshScale=[resolution, resolution, 1],
        heightfieldData=single.T.ravel().tolist(),  # x varies fastest
        numHeightfieldRows=rows,
        numHeightfieldColumns=columns,
    )
    # Bullet puts the middle of the height range at the body's origin.
    middle = (float(single.max()) + float(single.min())) / 2
    return int(client.createMultiBody(0, shape, basePosition=[*position, middle]))
