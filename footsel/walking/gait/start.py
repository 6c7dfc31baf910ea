"""How the robot stands when a walk begins."""

import numpy as np
from numpy.typing import NDArray

from footsel.errors import InputError
from footsel.footholds.pose import heading_rotation
from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.walking.course import WalkCourse
from footsel.walking.gait.stance import HEIGHT, places

Array = NDArray[np.float64]

#: By how much starts differ: the base's place, its heading, the feet's places, each at most. [m], [rad], [m]
PLACE, HEADING, FOOT = 0.03, 0.03, 0.015
#: Feet begin this far above the ground. [m]
DROP = 0.002


def standing_start(robot: Robot, course: WalkCourse, seed: int) -> tuple[Array, Array]:
    """Placement of the base (4, 4) in W and joints (12,) of a level stance near the course's start.

    Raises InputError if the ground there is so uneven that a leg cannot reach it.
    """
    rng = np.random.default_rng([seed, 0])
    x, y, yaw = course.start
    base = np.eye(4)
    base[:3, :3] = heading_rotation(yaw + rng.uniform(-HEADING, HEADING))
    base[:2, 3] = np.array([x, y]) + rng.uniform(-PLACE, PLACE, 2)
    feet = places() + rng.uniform(-FOOT, FOOT, (4, 2))
    xy = base[:2, 3] + feet @ base[:2, :2].T
    radius = robot.description.foot_radius
    # A foot's lowest point is above the highest ground under it.
    around = radius * np.array([[i, j] for i in (-1, 0, 1) for j in (-1, 0, 1)])
    ground = course.ground.sample(xy[:, None] + around).astype(np.float64).max(axis=1)
    base[2, 3] = ground.mean() + HEIGHT
    joints = np.empty((4, 3))
    for k, leg in enumerate(LEGS):
        centre = np.array([*feet[k], ground[k] + radius + DROP - base[2, 3]])
        angles, reachable = robot.kinematics[leg].inverse(centre - robot.layout.hips[leg])
        if not reachable[0]:
            raise InputError(f"{course.name}: {leg} cannot stand at the start", "start where the ground is more even")
        joints[k] = angles[0]
    return base, joints.ravel()
