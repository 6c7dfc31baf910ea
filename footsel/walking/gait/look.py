"""Lowering the head: a robot that maps as it goes looks down over an edge before its feet need to know what lies there.

Behind an edge the ground is hidden until the camera is nearly over it, and by then a level camera looks far ahead: the
first treads on the way down would stay unknown, and never be stepped on.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from footsel.footholds import BasePose
from footsel.footholds.pose import heading_rotation
from footsel.robot.robot import Robot
from footsel.terrain import ElevationMap
from footsel.walking.control.base_pose import STEEPEST
from footsel.walking.gait.line import Line
from footsel.walking.gait.poses import Situation, StepPoses, flaw

Array = NDArray[np.float64]

#: Where the ground is looked for, ahead of and beside the base's middle, from just ahead of the fore feet. [m]
AHEAD, BESIDE = (0.38, 0.70), 0.35
#: Unknown cells are as low as the lowest that is known so near to them, and matter if not so far below all feet. [m]
AROUND, LEVELS = 0.16, 0.25
#: So much unknown ground is worth a look, from a place so far from that of the last. [m^2], [m]
HIDDEN, ELSEWHERE = 0.015, 0.08
#: How far ahead of the base's middle the hidden ground should begin, and how far the base goes for that. [m]
BEGIN, SHIFT = 0.49, 0.12
#: And the base has to get lower with its head by so much, with its limbs this near to the ground at worst. [rad], [m]
LOWER, LEAST_CLEARANCE = 0.1, -0.02


class Lookout:
    """Says when to look down along a line, and with which pose of the base. watch_limbs: as of StepPoses."""

    def __init__(self, robot: Robot, line: Line, watch_limbs: bool = True) -> None:
        self._line, self._radius = line, robot.description.foot_radius
        self._poses = StepPoses(robot, line.yaw, watch_limbs)
        self._last = -np.inf

    def pose(self, now: Situation, stuck: bool) -> BasePose | None:
        """To look from; none if there is nothing to see, or it has been looked for from here.

        stuck: whether there is no step without another look.
        """
        along = float(self._line.to_line(now.base.position[:2])[0])
        if abs(along - self._last) < ELSEWHERE:
            return None
        lowest = float(now.feet[:, 2].min()) - self._radius
        begin, area = hidden_ground(now.obstacles, now.base, lowest)
        if not stuck and (area < HIDDEN or begin > BEGIN + SHIFT):
            return None
        way = float(np.clip(begin - BEGIN, -SHIFT, SHIFT)) if area else 0.0
        answer = self._poses.head_down(now, STEEPEST, way)
        if flaw(answer) or answer.clearance < LEAST_CLEARANCE or answer.pose.pitch < now.base.pitch + LOWER:
            return None
        self._last = along
        return answer.pose


def hidden_ground(elevation_map: ElevationMap, base: BasePose, lowest: float) -> tuple[float, float]:
    """Where the unknown ground ahead begins that feet may want to stand on, ahead of the base, and its area.

    lowest: height that the lowest foot stands at, in [m]. Returns [m], [m^2].
    """
    resolution = elevation_map.resolution
    rim = round(AROUND / resolution)
    # Ground beyond the window may be what its cells are as low as.
    x, y = (np.arange(low - AROUND, high + AROUND, resolution) for low, high in (AHEAD, (-BESIDE, BESIDE)))
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1) @ heading_rotation(base.yaw)[:2, :2].T
    heights = elevation_map.sample(base.position[:2] + points)
    known = np.isfinite(heights)
    level = ndimage.minimum_filter(np.where(known, heights, np.inf), 2 * rim + 1, mode="nearest")
    hidden = (~known & np.isfinite(level) & (level > lowest - LEVELS))[rim:-rim, rim:-rim]
    begin = float(np.percentile(x[rim:-rim][np.nonzero(hidden)[0]], 25)) if hidden.any() else np.inf
    return begin, float(hidden.sum()) * resolution**2
