"""Convex bodies as rows of numbers, for compiled code: where a body reaches furthest along a direction.

A row holds the kind, three half sizes, the centre and the three axes (unit vectors, one after another):
a box has its half sides, a cylinder or capsule along its third axis has its radius and its half length, a sphere is a
capsule without length. A prism, three vertices and all below them down to a level, is what lies under one triangle of
the terrain; its row holds the vertices and the level.
"""

from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

from footsel.compiled import compiled, inlined

BOX, CYLINDER, CAPSULE, PRISM = 0.0, 1.0, 2.0, 3.0

#: Where things are in a row.
SIZES, CENTRE, AXES, ROW = 1, 4, 7, 16
#: The level of a prism's underside, after its nine coordinates.
BOTTOM = 10


def shape_row(shape: Any) -> tuple[NDArray[np.float64], bool]:
    """Row (16,) of a coal shape in its own frame, and whether it is that shape; otherwise it is a box around it."""
    row = np.zeros(ROW)
    row[AXES:] = np.eye(3).ravel()
    if isinstance(shape, coal.Box):
        row[:CENTRE] = BOX, *np.asarray(shape.halfSide).ravel()
    elif isinstance(shape, coal.Cylinder):
        row[:CENTRE] = CYLINDER, shape.radius, shape.halfLength, 0.0
    elif isinstance(shape, coal.Capsule):
        row[:CENTRE] = CAPSULE, shape.radius, shape.halfLength, 0.0
    elif isinstance(shape, coal.Sphere):
        row[:CENTRE] = CAPSULE, shape.radius, 0.0, 0.0
    else:
        shape.computeLocalAABB()
        low, high = np.asarray(shape.aabb_local.min_).ravel(), np.asarray(shape.aabb_local.max_).ravel()
        row[:CENTRE] = BOX, *((high - low) / 2)
        row[CENTRE:AXES] = (low + high) / 2
        return row, False
    return row, True


def placed(row: NDArray[np.float64], rotation: NDArray[np.float64], translation: NDArray[np.float64]) -> Any:
    """The row turned by rotation (3, 3), then moved by translation (3,), in [m]."""
    moved = np.empty(ROW)
    place(row, np.ascontiguousarray(rotation), np.ascontiguousarray(translation), moved)
    return moved


@compiled
def place(
    row: NDArray[np.float64], rotation: NDArray[np.float64], translation: NDArray[np.float64], out: NDArray[np.float64]
) -> None:  # pragma: no cover - compiled
    """`placed` into `out`."""
    for k in range(CENTRE):
        out[k] = row[k]
    for i in range(3):
        r0, r1, r2 = rotation[i, 0], rotation[i, 1], rotation[i, 2]
        out[CENTRE + i] = translation[i] + r0 * row[CENTRE] + r1 * row[CENTRE + 1] + r2 * row[CENTRE + 2]
        for k in range(AXES, ROW, 3):
            out[k + i] = r0 * row[k] + r1 * row[k + 1] + r2 * row[k + 2]


@inlined
def _along(row: NDArray[np.float64], axis: int, x: float, y: float, z: float) -> float:  # pragma: no cover - compiled
    """The direction's component along an axis of the body."""
    k = AXES + 3 * axis
    return float(row[k] * x + row[k + 1] * y + row[k + 2] * z)


@compiled
def support(
    row: NDArray[np.float64], x: float, y: float, z: float
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """The point of the body that is furthest along the direction (x, y, z), of any length but zero."""
    kind = row[0]
    if kind == PRISM:
        best, furthest = 1, -np.inf
        weight = max(z, 0.0)
        for k in range(1, 10, 3):
            along = row[k] * x + row[k + 1] * y + row[k + 2] * weight
            if along > furthest:
                best, furthest = k, along
        return row[best], row[best + 1], row[best + 2] if z > 0.0 else row[BOTTOM]
    if kind == BOX:
        px, py, pz = row[CENTRE], row[CENTRE + 1], row[CENTRE + 2]
        for axis in range(3):
            half = row[SIZES + axis]
            if _along(row, axis, x, y, z) < 0.0:
                half = -half
            k = AXES + 3 * axis
            px += half * row[k]
            py += half * row[k + 1]
            pz += half * row[k + 2]
        return px, py, pz
    along = _along(row, 2, x, y, z)
    half = row[SIZES + 1] if along >= 0.0 else -row[SIZES + 1]
    k = AXES + 6
    px, py, pz = row[CENTRE] + half * row[k], row[CENTRE + 1] + half * row[k + 1], row[CENTRE + 2] + half * row[k + 2]
    if kind == CYLINDER:
        x, y, z = x - along * row[k], y - along * row[k + 1], z - along * row[k + 2]
    length = np.sqrt(x * x + y * y + z * z)
    if length > 1e-12:
        # Along a cylinder's axis every point of its end is as far as the middle.
        scale = row[SIZES] / length
        px, py, pz = px + scale * x, py + scale * y, pz + scale * z
    return px, py, pz


@compiled
def extent(row: NDArray[np.float64], x: float, y: float, z: float) -> float:  # pragma: no cover - compiled
    """How far a body other than a prism reaches from its centre along a unit vector, in [m]."""
    along = abs(_along(row, 2, x, y, z))
    if row[0] == BOX:
        across = abs(_along(row, 0, x, y, z)) * row[SIZES] + abs(_along(row, 1, x, y, z)) * row[SIZES + 1]
        return float(across + along * row[SIZES + 2])
    across = 1.0 if row[0] == CAPSULE else np.sqrt(max(1.0 - along * along, 0.0))
    return float(along * row[SIZES + 1] + across * row[SIZES])
