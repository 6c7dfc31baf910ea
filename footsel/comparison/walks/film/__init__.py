"""Walks on film: the robot on its course, footholds, support polygon and cost map drawn in."""

from footsel.comparison.walks.film.observers import Film, Still

__all__ = ["Film", "Still"]
