"""Depth images -> robot-centric elevation map with uncertainty, after Fankhauser 2014; numpy alone."""

from footsel.mapping.camera import CameraModel
from footsel.mapping.capsule import Capsule
from footsel.mapping.config import MappingConfig
from footsel.mapping.depth_noise import DepthNoise, FittedNoise, StereoNoise
from footsel.mapping.elevation_mapping import ElevationMapping
from footsel.mapping.realsense import D435

__all__ = [
    "D435",
    "CameraModel",
    "Capsule",
    "DepthNoise",
    "ElevationMapping",
    "FittedNoise",
    "MappingConfig",
    "StereoNoise",
]
