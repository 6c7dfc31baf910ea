"""Seeded terrain courses: families of ground, edges, stones and obstacles, and a map composed of them."""

from footsel.terrain.courses.composition import training_map
from footsel.terrain.courses.registry import FAMILIES, make_course

__all__ = ["FAMILIES", "make_course", "training_map"]
