"""The straight line that a walk follows."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.pose import heading_rotation
from footsel.walking.course import WalkCourse

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Line:
    """From the start to the goal. origin: (2,) start, in W, in [m]. yaw: direction, in [rad]. length: in [m]."""

    origin: Array
    yaw: float
    length: float

    @classmethod
    def of(cls, course: WalkCourse) -> "Line":
        """The line of a course."""
        start, goal = np.array(course.start[:2]), np.array(course.goal)
        dx, dy = (goal - start).tolist()
        return cls(start, float(np.arctan2(dy, dx)), float(np.hypot(dx, dy)))

    def to_line(self, xy: Array) -> Array:
        """(..., 2) along and to the left of the line, for points (..., 2) in W, in [m]."""
        return np.asarray((xy - self.origin) @ heading_rotation(self.yaw)[:2, :2])

    def to_world(self, along_across: Array) -> Array:
        """The inverse of `to_line`."""
        return np.asarray(self.origin + along_across @ heading_rotation(self.yaw)[:2, :2].T)
