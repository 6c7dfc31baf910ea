"""The base's pose in the world frame: x, y, z in [m]; roll, pitch, yaw in [rad] (R = Rz(yaw) Ry(pitch) Rx(roll))."""

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.errors import InputError


@dataclass(frozen=True)
class BasePose:
    """Base frame B in the world frame W."""

    x: float
    y: float
    z: float
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0

    @classmethod
    def of(cls, pose: "BasePose | ArrayLike") -> "BasePose":
        """From six numbers x, y, z, roll, pitch, yaw; raises InputError for another count or for NaN and inf."""
        if isinstance(pose, BasePose):
            return pose
        try:
            numbers = np.asarray(pose, dtype=np.float64).reshape(-1)
        except (TypeError, ValueError):
            raise InputError(f"base pose {pose!r} is not numeric", "give x y z roll pitch yaw") from None
        if numbers.shape != (6,) or not np.isfinite(numbers).all():
            raise InputError(f"base pose is {numbers.tolist()}", "give six finite numbers: x y z roll pitch yaw")
        return cls(*numbers.tolist())

    @property
    def position(self) -> NDArray[np.float64]:
        """(3,) origin of B in W, in [m]."""
        return np.array([self.x, self.y, self.z])

    def rotation(self) -> NDArray[np.float64]:
        """(3, 3) rotation from B to W."""
        return heading_rotation(self.yaw) @ tilt_rotation(self.roll, self.pitch)

    def as_list(self) -> list[float]:
        """[x, y, z, roll, pitch, yaw]."""
        return list(astuple(self))


def heading_rotation(yaw: float) -> NDArray[np.float64]:
    """(3, 3) rotation from the heading frame H to the world frame W."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def tilt_rotation(roll: float, pitch: float) -> NDArray[np.float64]:
    """(3, 3) rotation from the base frame B to the heading frame H: Ry(pitch) Rx(roll)."""
    cr, sr, cp, sp = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch)
    return np.array([[cp, sp * sr, sp * cr], [0.0, cr, -sr], [-sp, cp * sr, cp * cr]])
