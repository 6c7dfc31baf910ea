"""A camera beside the line that is walked, and where it sees a point."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

#: Vertical opening, [deg]; the camera looks down by ELEVATION and from the robot's right, a little from ahead. [rad]
FIELD_OF_VIEW = 24.0
ELEVATION, AZIMUTH = np.deg2rad(33.0), np.deg2rad(-72.0)


@dataclass(frozen=True, eq=False)
class Camera:
    """width, height: of the picture, in [px]. view, projection: (4, 4) OpenGL's matrices."""

    width: int
    height: int
    view: Array
    projection: Array

    @classmethod
    def beside(cls, focus: ArrayLike, yaw: float, span: float, width: int, height: int) -> "Camera":
        """Looks at the point `focus` (3,) so that `span` [m] along the direction `yaw` fit into the width."""
        half_height = np.tan(np.deg2rad(FIELD_OF_VIEW) / 2)
        distance = span / 2 / (half_height * width / height)
        azimuth = yaw + AZIMUTH
        away = np.array([np.cos(ELEVATION) * np.cos(azimuth), np.cos(ELEVATION) * np.sin(azimuth), np.sin(ELEVATION)])
        right = np.cross([0.0, 0.0, 1.0], away)
        right /= np.linalg.norm(right)
        turn = np.stack([right, np.cross(away, right), away])
        view = np.eye(4)
        view[:3, :3] = turn
        view[:3, 3] = -turn @ (np.asarray(focus, dtype=np.float64) + distance * away)
        near, far = 0.2 * distance, 3 * distance
        projection = np.zeros((4, 4))
        projection[0, 0], projection[1, 1] = height / (width * half_height), 1 / half_height
        projection[2, 2:] = -(far + near) / (far - near), -2 * far * near / (far - near)
        projection[3, 2] = -1
        return cls(width, height, view, projection)

    def pixels(self, points: ArrayLike) -> Array:
        """(k, 2) column and row at which world points (k, 3) appear, in [px]."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        clip = np.column_stack([points, np.ones(len(points))]) @ (self.projection @ self.view).T
        ndc = clip[:, :2] / clip[:, 3:]
        return np.asarray((ndc * [1, -1] + 1) / 2 * [self.width, self.height])
