"""What a walking robot sees: depth cameras in PyBullet, a pose that drifts, and the map made of both."""

from footsel.walking.sensing.camera_map import CameraMap
from footsel.walking.sensing.noisy_map import noisy_map
from footsel.walking.sensing.pose_drift import PoseDrift

__all__ = ["CameraMap", "PoseDrift", "noisy_map"]
