"""Scenes whose depth is known exactly: boxes on an even ground."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from footsel.mapping import CameraModel


def placement(x: float, y: float, z: float, pitch_deg: float = 30.0, yaw_deg: float = 0.0) -> np.ndarray:
    """(4, 4) of a camera that looks along `yaw` and `pitch` degrees down."""
    pitch, yaw = np.deg2rad(pitch_deg), np.deg2rad(yaw_deg)
    forward = np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), -np.sin(pitch)])
    right = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    matrix[:3, 3] = x, y, z
    return matrix


def base_at(x: float, y: float, z: float = 0.5) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


@dataclass(frozen=True)
class Scene:
    """slope: (2,) of the ground, which passes through the origin. boxes: ((x0, y0, z0), (x1, y1, z1)), in [m]."""

    boxes: tuple = ()
    slope: tuple = (0.0, 0.0)

    def depth(self, camera: CameraModel, world_camera: np.ndarray) -> np.ndarray:
        """(height, width) along the optical axis, infinite where there is nothing."""
        rays = world_camera[:3, :3] @ camera.rays.astype(np.float64)
        eye = world_camera[:3, 3]
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = rays[2] - self.slope[0] * rays[0] - self.slope[1] * rays[1]
            ground = -(eye[2] - self.slope[0] * eye[0] - self.slope[1] * eye[1]) / rise
            depth = np.where(ground > 0, ground, np.inf)
            for low, high in self.boxes:
                a, b = ((np.array(corner)[:, None] - eye[:, None]) / rays for corner in (low, high))
                enter, leave = np.minimum(a, b).max(axis=0), np.maximum(a, b).min(axis=0)
                depth = np.where((enter <= leave) & (enter > 0), np.minimum(depth, enter), depth)
        return depth.reshape(camera.height, camera.width)

    def heights(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(nx, ny) of the terrain over the points of a grid."""
        x, y = np.meshgrid(x, y, indexing="ij")
        heights = self.slope[0] * x + self.slope[1] * y
        for low, high in self.boxes:
            inside = (x >= low[0]) & (x < high[0]) & (y >= low[1]) & (y < high[1])
            heights = np.where(inside, np.maximum(heights, high[2]), heights)
        return heights


@pytest.fixture(scope="session")
def worlds() -> SimpleNamespace:
    """The makers above."""
    return SimpleNamespace(Scene=Scene, placement=placement, base_at=base_at)
