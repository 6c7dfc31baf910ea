"""Elevation maps, local maps, their file formats, seeded terrain courses and the image that a network sees."""

from footsel.terrain.elevation_map import ElevationMap
from footsel.terrain.local_map import CELLS, LocalMap, extract_local_map, extract_local_map_as_paper

__all__ = ["CELLS", "ElevationMap", "LocalMap", "extract_local_map", "extract_local_map_as_paper"]
