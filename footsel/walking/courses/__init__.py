"""Courses to walk: seeded obstacles between flat aprons, and lines across scanned maps."""

from footsel.walking.courses.registry import WALK_COURSES, make_walk_course
from footsel.walking.courses.scanned import course_across

__all__ = ["WALK_COURSES", "course_across", "make_walk_course"]
