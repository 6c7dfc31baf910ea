"""Collision bodies as thick lines: what balls along a body need to know of it."""

from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray


def medial_axis(shape: Any) -> tuple[int, float, NDArray[np.float64]]:
    """Index of the longest axis of a coal geometry, half its length along it, and half its widths (2,), in [m].

    Round bodies have their axis where coal has it, along z; meshes count by their bounding box.
    """
    if isinstance(shape, coal.Sphere):
        return 2, float(shape.radius), np.full(2, shape.radius)
    if isinstance(shape, coal.Cylinder):
        return 2, float(shape.halfLength), np.full(2, shape.radius)
    if isinstance(shape, coal.Capsule):
        return 2, float(shape.halfLength + shape.radius), np.full(2, shape.radius)
    if isinstance(shape, coal.Box):
        half = np.asarray(shape.halfSide, dtype=np.float64).ravel()
    else:
        shape.computeLocalAABB()
        half = np.asarray(shape.aabb_local.max_ - shape.aabb_local.min_, dtype=np.float64) / 2
    axis = int(np.argmax(half))
    return axis, float(half[axis]), np.delete(half, axis)
