"""What a walking robot sees: depth cameras in PyBullet, a pose that drifts, and the map made of both."""

from collections.abc import Callable

import numpy as np

from footsel.robot import load_robot
from footsel.walking.sensing.camera_map import CameraMap
from footsel.walking.sensing.noisy_map import noisy_map
from footsel.walking.sensing.pose_drift import DriftRates, PoseDrift
from footsel.walking.simulation import Simulation


def camera_sight(seed: int, robot: str = "anymal_b") -> tuple[Callable[[Simulation], CameraMap], PoseDrift]:
    """What `walk` takes as map_source and estimator for a robot that knows only what it sees; the same for a seed."""
    for_pose, for_images = np.random.default_rng(seed).spawn(2)
    drift = PoseDrift(for_pose)
    return lambda simulation: CameraMap(load_robot(robot), simulation, drift.covariance, for_images), drift


__all__ = ["CameraMap", "DriftRates", "PoseDrift", "camera_sight", "noisy_map"]
