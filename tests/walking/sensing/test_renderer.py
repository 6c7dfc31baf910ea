"""The renderer's depth is the scene's, pixel for pixel."""

import numpy as np
import pytest

from footsel.mapping import CameraModel, FittedNoise
from footsel.walking.bullet import BulletWorld
from footsel.walking.ground import make_ground
from footsel.walking.sensing.mounts import FRONT, REAR
from footsel.walking.sensing.renderer import true_depth

SLOPE = np.array([0.2, -0.1])


def looking_down(roll: float, pitch: float) -> np.ndarray:
    ahead, right = np.array([np.cos(pitch), 0, -np.sin(pitch)]), np.array([0, -1.0, 0])
    c, s = np.cos(roll), np.sin(roll)
    placement = np.eye(4)
    axes = np.column_stack([right, np.cross(ahead, right), ahead])
    placement[:3, :3] = axes @ [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    placement[:3, 3] = 0.1, -0.2, 1.0
    return placement


@pytest.mark.parametrize(("width", "height"), [(64, 48), (61, 37)])
@pytest.mark.parametrize("roll", [0.0, 0.8])
def test_a_plane_has_the_depth_of_a_plane(width, height, roll):
    """Half a pixel beside the right place is an error of millimetres here."""
    world = BulletWorld()
    x = (np.arange(400) - 199.5) * 0.05
    make_ground(world, SLOPE[0] * x[:, None] + SLOPE[1] * x, 0.05, np.zeros(2))
    camera = CameraModel(width, height, 40.0, 44.0, 0.45 * width, 0.52 * height, FittedNoise())
    eye = looking_down(roll, np.deg2rad(50))
    rays = eye[:3, :3] @ camera.rays.astype(np.float64)
    expected = -(eye[2, 3] - SLOPE @ eye[:2, 3]) / (rays[2] - SLOPE @ rays[:2])
    seen = (expected > 0) & (expected < 5)
    assert seen.mean() > 0.7
    depth = true_depth(world, camera, eye).ravel()
    world.disconnect()
    assert np.abs(depth - expected)[seen].max() < 1e-4


def test_where_nothing_is_depth_is_infinite():
    world = BulletWorld()
    camera = CameraModel(16, 12, 10.0, 10.0, 7.5, 5.5, FittedNoise())
    assert np.isinf(true_depth(world, camera, np.eye(4))).all()
    world.disconnect()


@pytest.mark.parametrize(("mount", "side"), [(FRONT, 1), (REAR, -1)])
def test_cameras_look_along_the_robot_and_down(mount, side):
    turn = mount[:3, :3]
    assert np.allclose(turn @ turn.T, np.eye(3)) and np.isclose(np.linalg.det(turn), 1)
    assert np.allclose(turn[:, 2], [side * np.cos(np.pi / 6), 0, -0.5])
    assert np.allclose(turn[:, 0], [0, -side, 0])
    assert np.isclose(mount[0, 3], side * 0.484)
