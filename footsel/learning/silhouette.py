"""Points of a convex body that meet the ground first: its outline seen from above, and its underside."""

import numpy as np
from numpy.typing import NDArray

from footsel.oracle.convex import AXES, BOX, CAPSULE, CENTRE, SIZES

#: Points along the outline; spacing of those of the underside, in [m].
OUTLINE, UNDERSIDE = 60, 0.012
#: Spacing of the surface that they are chosen from, in [m].
FINE = 0.004


def surface_points(row: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m, 3) points all over the surface of a box, cylinder or capsule, a row as in footsel.oracle.convex, in [m]."""
    sizes, axes = row[SIZES:CENTRE], row[AXES:].reshape(3, 3)
    if row[0] == BOX:
        sides = [np.linspace(-half, half, 2 + int(2 * half / FINE)) for half in sizes]
        local = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
        local = local[(np.abs(local) == sizes).any(axis=1)]
    else:
        radius, half = sizes[0], sizes[1]
        turns = np.linspace(0, 2 * np.pi, 3 + int(2 * np.pi * radius / FINE), endpoint=False)
        # Radius and height of a profile, which turns around the axis: half a circle or a flat end, and the wall.
        if row[0] == CAPSULE:
            end = np.linspace(0, np.pi / 2, 2 + int(radius / FINE))
            rims, levels = radius * np.sin(end), half + radius * np.cos(end)
        else:
            rims = np.linspace(0, radius, 2 + int(radius / FINE))
            levels = np.full(len(rims), half)
        wall = np.linspace(-half, half, 2 + int(2 * half / FINE))
        rims = np.concatenate([rims, np.full(len(wall), radius), rims])
        levels = np.concatenate([levels, wall, -levels])
        circle = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
        local = np.concatenate(
            [rims[:, None, None] * circle, np.broadcast_to(levels[:, None, None], (len(levels), len(turns), 1))], axis=2
        ).reshape(-1, 3)
    return row[CENTRE:AXES] + local @ axes


def seen_from_above(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(OUTLINE, 3) points evenly along the outline of a body's points (m, 3), z upwards, each as low as it gets."""
    outline = []
    for turn in np.linspace(0, 2 * np.pi, OUTLINE, endpoint=False):
        outwards = points[:, :2] @ (np.cos(turn), np.sin(turn))
        farthest = points[outwards > outwards.max() - FINE / 4]
        outline.append(farthest[farthest[:, 2].argmin()])
    ring = np.array([*outline, outline[0]])
    travelled = np.concatenate([[0.0], np.linalg.norm(np.diff(ring[:, :2], axis=0), axis=1).cumsum()])
    at = np.linspace(0, travelled[-1], OUTLINE, endpoint=False)
    return np.column_stack([np.interp(at, travelled, ring[:, axis]) for axis in range(3)])


def underside(points: NDArray[np.float64], outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k, 3) the lowest of the points (m, 3) in every square of UNDERSIDE as seen from above, but near the outline."""
    order = np.lexsort((points[:, 2], *np.floor(points[:, :2] / UNDERSIDE).T))
    squares = np.floor(points[order, :2] / UNDERSIDE)
    first = np.concatenate([[True], (np.diff(squares, axis=0) != 0).any(axis=1)])
    lowest = points[order][first]
    apart = np.linalg.norm(lowest[:, None, :2] - outline[:, :2], axis=2).min(axis=1)
    inner: NDArray[np.float64] = lowest[apart > 0.6 * UNDERSIDE]
    return inner
