"""Pictures of a robot on its course by PyBullet's TinyRenderer, which needs no GPU.

The ground is rendered once for a camera and the robot alone for every picture; the nearer of the two is seen.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image

from footsel.comparison import palette, panels
from footsel.comparison.walks.film.camera import Camera
from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.terrain import ElevationMap
from footsel.walking.bullet import BulletWorld, pybullet

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]

SKY = (236, 240, 244)
BODY = "#3a4350"
LIGHT = (-1.0, -1.5, 3.0)
#: Beyond this depth is nothing: the renderer's 1, in single precision.
NOTHING = 1 - 1e-5


class Stage:
    """A course as one camera sees it, and the robot on it. Nothing is simulated here."""

    def __init__(self, ground: ElevationMap, robot: Robot, camera: Camera) -> None:
        self.camera = camera
        self._backdrop = self._render_ground(ground)
        self._actor = _Actor(robot)

    def render(self, base: Array, joints: Array) -> Pixels:
        """(height, width, 3) picture. base: (4, 4) placement in W. joints: (12,) by LEGS and HAA HFE KFE, in [rad]."""
        self._actor.pose(base, joints)
        ground, ground_depth = self._backdrop
        robot, depth = _shoot(self._actor.world, self.camera)
        return np.where((depth < ground_depth)[..., None], robot, ground)

    def close(self) -> None:
        """End the world of the robot's shapes."""
        self._actor.world.disconnect()

    def _render_ground(self, ground: ElevationMap) -> tuple[Pixels, Array]:
        """Picture and depths of the ground without the robot."""
        world = BulletWorld()
        try:
            _add_ground(world, ground)
            picture, depth = _shoot(world, self.camera)
        finally:
            world.disconnect()
        picture[depth > NOTHING] = SKY
        return picture, depth


class _Actor:
    """The robot's collision bodies as coloured shapes in a world of their own."""

    def __init__(self, robot: Robot) -> None:
        self.world = BulletWorld()
        self._model, self._geometry = robot.model, robot.geometry
        self._data, self._places = robot.model.createData(), robot.geometry.createData()
        joints = [robot.model.getJointId(name) for leg in LEGS for name in robot.description.joints[leg]]
        self._order = [robot.model.joints[joint].idx_q for joint in joints]
        leg_of = {joint: LEGS[number // 3] for number, joint in enumerate(joints)}
        self._bodies = [
            self._add(item.geometry, palette.LEG_COLOURS[leg_of[item.parentJoint]] if item.parentJoint else BODY)
            for item in robot.geometry.geometryObjects
        ]

    def pose(self, base: Array, joints: Array) -> None:
        q = pin.neutral(self._model)
        q[self._order] = joints
        pin.updateGeometryPlacements(self._model, self._data, self._geometry, self._places, q)
        for body, place in zip(self._bodies, self._places.oMg, strict=True):
            placement = pin.SE3(base) * place
            quaternion_xyzw = pin.Quaternion(placement.rotation).coeffs()
            self.world.resetBasePositionAndOrientation(body, placement.translation.tolist(), quaternion_xyzw.tolist())

    def _add(self, shape: Any, colour: str) -> int:
        rgba = [*to_rgb(colour), 1.0]
        if isinstance(shape, coal.Box):
            visual = self.world.createVisualShape(
                pybullet.GEOM_BOX, halfExtents=np.asarray(shape.halfSide).tolist(), rgbaColor=rgba
            )
        elif isinstance(shape, coal.Sphere):
            visual = self.world.createVisualShape(pybullet.GEOM_SPHERE, radius=float(shape.radius), rgbaColor=rgba)
        else:
            visual = self.world.createVisualShape(
                pybullet.GEOM_CYLINDER, radius=float(shape.radius), length=2 * float(shape.halfLength), rgbaColor=rgba
            )
        return int(self.world.createMultiBody(0, baseVisualShapeIndex=visual))


def _add_ground(world: BulletWorld, ground: ElevationMap) -> None:
    """The map as a mesh, coloured by height as in all drawings of maps."""
    heights = ground.elevation.astype(np.float64)
    nx, ny = ground.shape
    x, y = np.meshgrid(ground.x(), ground.y(), indexing="ij")
    slope_x, slope_y = np.gradient(heights, ground.resolution)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(heights)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    i, j = np.meshgrid((np.arange(nx) + 0.5) / nx, (np.arange(ny) + 0.5) / ny, indexing="ij")
    index = np.arange(nx * ny).reshape(nx, ny)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[:-1, 1:], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)])
    shape = world.createVisualShape(
        pybullet.GEOM_MESH,
        vertices=np.stack([x, y, heights], axis=-1).reshape(-1, 3).tolist(),
        indices=triangles.ravel().tolist(),
        normals=normals.reshape(-1, 3).tolist(),
        uvs=np.stack([i, j], axis=-1).reshape(-1, 2).tolist(),
        rgbaColor=[1, 1, 1, 1],
    )
    body = world.createMultiBody(0, baseVisualShapeIndex=shape)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "ground.png"
        colours = (255 * panels.shaded(heights, ground.resolution)[..., :3]).astype(np.uint8)
        # A texture begins at its lower left.
        Image.fromarray(np.ascontiguousarray(colours.transpose(1, 0, 2)[::-1])).save(path)
        world.changeVisualShape(body, -1, textureUniqueId=world.loadTexture(str(path)))


def _shoot(world: BulletWorld, camera: Camera) -> tuple[Pixels, Array]:
    """(height, width, 3) picture and (height, width) depth from 0 at the nearest to 1 where there is nothing."""
    _, _, rgba, depth, _ = world.getCameraImage(
        camera.width,
        camera.height,
        viewMatrix=camera.view.T.ravel().tolist(),
        projectionMatrix=camera.projection.T.ravel().tolist(),
        lightDirection=LIGHT,
        shadow=0,
        renderer=pybullet.ER_TINY_RENDERER,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
    )
    shape = (camera.height, camera.width)
    picture = np.asarray(rgba, dtype=np.uint8).reshape(*shape, 4)[..., :3].copy()
    return picture, np.asarray(depth, dtype=np.float64).reshape(shape)
