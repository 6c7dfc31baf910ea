"""What a camera should not take for terrain: parts of the robot that carries it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.errors import InputError
from footsel.mapping.camera import CameraModel


@dataclass(frozen=True, eq=False)
class Capsule:
    """All points within `radius` of the line from `start` to `end`, (3,) in W, in [m]; if they are one, a sphere."""

    start: NDArray[np.float64]
    end: NDArray[np.float64]
    radius: float

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            point = np.asarray(getattr(self, name), dtype=np.float64)
            if point.shape != (3,) or not np.isfinite(point).all():
                raise InputError(f"a capsule's {name} is {point.tolist()}", "expected three finite numbers, in metres")
            object.__setattr__(self, name, point)
        if not (np.isfinite(self.radius) and self.radius >= 0):
            raise InputError(f"a capsule's radius is {self.radius}", "expected metres, 0 or more")

    def contains(self, points: NDArray[np.floating]) -> NDArray[np.bool_]:
        """(k,) whether points (k, 3) lie inside."""
        axis = self.end - self.start
        length = float(axis @ axis)
        offset = points - self.start
        along = np.clip(offset @ axis / length, 0, 1) if length else np.zeros(len(points))
        distance = offset - along[:, None] * axis
        return np.asarray(np.einsum("ij,ij->i", distance, distance) <= self.radius**2)

    def seen_from(self, world_camera: NDArray[np.float64], margin: float) -> "Capsule":
        """The same in the camera's frame, `margin` thicker, in [m]."""
        turn, place = world_camera[:3, :3], world_camera[:3, 3]
        return Capsule((self.start - place) @ turn, (self.end - place) @ turn, self.radius + margin)


def without_bodies(depth: NDArray[np.float32], camera: CameraModel, bodies: Sequence[Capsule]) -> NDArray[np.float32]:
    """(height, width) depth image with 0 where a reading lies in a body, given in the camera's frame."""
    left: NDArray[np.float32] = depth.copy()
    rays = camera.rays.reshape(3, camera.height, camera.width)
    for body in bodies:
        rows, columns = _window(camera, body)
        part = left[rows, columns]
        points = (rays[:, rows, columns] * part).reshape(3, -1).T
        part[body.contains(points).reshape(part.shape)] = 0
    return left


def _window(camera: CameraModel, body: Capsule) -> tuple[slice, slice]:
    """The rows and columns that can show a body: all if it reaches behind the camera's plane."""
    ends = np.stack([body.start, body.end])
    if ends[:, 2].max() + body.radius <= 0:
        return slice(0), slice(0)
    nearest = ends[:, 2].min() - body.radius
    if nearest <= 0:
        return slice(camera.height), slice(camera.width)
    # Corners of the box around the capsule: their images enclose its image.
    low, high = ends.min(axis=0) - body.radius, ends.max(axis=0) + body.radius
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    pixels, _ = camera.project(corners)
    first = np.clip(np.floor(pixels.min(axis=0)), 0, (camera.width, camera.height)).astype(int)
    last = np.clip(np.ceil(pixels.max(axis=0)) + 1, 0, (camera.width, camera.height)).astype(int)
    return slice(first[1], last[1]), slice(first[0], last[0])
