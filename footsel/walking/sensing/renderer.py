"""True depth images of a PyBullet world, without a GPU."""

import numpy as np
from numpy.typing import NDArray

from footsel.mapping import CameraModel
from footsel.walking.bullet import BulletWorld, pybullet

#: What is nearer is not drawn, what is farther is nothing. [m]
NEAR, FAR = 0.05, 10.0
#: From a camera's frame (x right, y down, z ahead) to OpenGL's (y up, z backwards).
OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])


def true_depth(world: BulletWorld, camera: CameraModel, world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """(height, width) depth along the optical axis, infinite where there is nothing within 10 m, in [m].

    world_camera: (4, 4) true placement of the camera's frame in W.
    """
    view = np.linalg.inv(world_camera @ OPENGL)
    image = world.getCameraImage(
        camera.width,
        camera.height,
        viewMatrix=view.T.ravel().tolist(),
        projectionMatrix=_projection(camera).T.ravel().tolist(),
        shadow=0,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
        renderer=pybullet.ER_TINY_RENDERER,
    )
    buffer = np.reshape(np.asarray(image[3], dtype=np.float64), (camera.height, camera.width))
    depth = FAR * NEAR / (FAR - (FAR - NEAR) * buffer)
    return np.where(depth < 0.999 * FAR, depth, np.inf)


def _projection(camera: CameraModel) -> NDArray[np.float64]:
    """(4, 4) OpenGL's projection.

    TinyRenderer puts the middle of OpenGL's picture at the pixel (width / 2, height / 2 - 1).
    """
    u, v = camera.cx, camera.cy + 1
    return np.array(
        [
            [2 * camera.fx / camera.width, 0, 1 - 2 * u / camera.width, 0],
            [0, 2 * camera.fy / camera.height, 2 * v / camera.height - 1, 0],
            [0, 0, -(FAR + NEAR) / (FAR - NEAR), -2 * FAR * NEAR / (FAR - NEAR)],
            [0, 0, -1, 0],
        ]
    )
