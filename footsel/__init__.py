"""Foothold selection for legged robots: an exact oracle, a network that learned it, and a runtime for the robot."""

from footsel.errors import FootselError
from footsel.terrain import ElevationMap, LocalMap

__version__ = "0.1.0"

__all__ = ["ElevationMap", "FootselError", "LocalMap", "__version__"]
