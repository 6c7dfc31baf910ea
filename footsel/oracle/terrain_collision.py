"""The third constraint: does the leg touch the terrain anywhere but at its foot?

Terrain is the solid below the triangulated heights of the known cells; unknown cells collide with nothing. Each body
is held against the prisms below the triangles under it, most of which one separating direction clears at once. What is
nearer to touching than a hundredth of a millimetre goes to coal.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import coal
import numpy as np
from numpy.typing import NDArray

from footsel.compiled import compiled
from footsel.oracle.convex import AXES, BOTTOM, CENTRE, PRISM, ROW, SIZES, extent, place, support
from footsel.oracle.overlap import BAND, CLEAR, COLLIDES, UNDECIDED, overlap, workspace
from footsel.oracle.swing_bodies import SwingBodies
from footsel.robot.leg_kinematics import link_frames

#: Unknown cells, and the underside of the solid, lie this far below the lowest known cell. [m]
FLOOR_DEPTH = 1.0


@dataclass(frozen=True, eq=False)
class Terrain:
    """Terrain of one local map, in its heading frame.

    heights: (n, n) float64 relative to the hip point, NaN = unknown, in [m]. resolution: in [m].
    """

    heights: NDArray[np.float64]
    resolution: float

    @property
    def floor(self) -> float:
        """Level of unknown cells and of the underside, in [m]."""
        return float(np.nanmin(self.heights)) - FLOOR_DEPTH

    @cached_property
    def vertices(self) -> NDArray[np.float64]:
        """(n, n) heights of the solid's vertices at the cell centres: unknown cells are at the floor, in [m]."""
        return np.where(np.isnan(self.heights), self.floor, self.heights)

    @cached_property
    def field(self) -> Any:
        """coal's height field: rows run along -y, columns along +x."""
        side = (len(self.heights) - 1) * self.resolution
        return coal.HeightFieldOBBRSS(side, side, np.asfortranarray(self.vertices.T[::-1]), self.floor)


class TerrainCollision:
    """Terrain collision of one leg."""

    def __init__(self, bodies: SwingBodies) -> None:
        self._bodies = bodies

    def check(self, terrain: Terrain, tilt: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(k,) whether the leg collides at angles (k, 3); tilt: (3, 3) rotation from base to heading frame."""
        verdict = np.zeros((len(angles), len(self._bodies.bodies)), dtype=np.uint8)
        bodies = self._bodies
        _judge(
            bodies.leg,
            bodies.link,
            bodies.rows,
            bodies.exact,
            np.ascontiguousarray(bodies.axes @ tilt.T),
            np.ascontiguousarray(angles),
            terrain.vertices,
            terrain.resolution,
            workspace(),
            verdict,
        )
        collides: NDArray[np.bool_] = (verdict == COLLIDES).any(axis=1)
        for cell in np.flatnonzero(~collides & (verdict == UNDECIDED).any(axis=1)):
            suspects = np.flatnonzero(verdict[cell] == UNDECIDED)
            collides[cell] = bool(self._ask(terrain, tilt, angles[cell], suspects, first_only=True))
        return collides

    def touching(self, terrain: Terrain, tilt: NDArray[np.float64], angles: NDArray[np.float64]) -> list[str]:
        """Names of the leg's bodies that touch the terrain at angles (3,)."""
        found = self._ask(terrain, tilt, angles, np.arange(len(self._bodies.bodies)), first_only=False)
        return [self._bodies.bodies[index].name for index in found]

    def _ask(
        self,
        terrain: Terrain,
        tilt: NDArray[np.float64],
        angles: NDArray[np.float64],
        suspects: NDArray[np.intp],
        first_only: bool,
    ) -> list[int]:
        """Indices of the suspects that coal finds in the terrain. Results are fresh for each question."""
        field_placement = coal.Transform3s(tilt.T, np.zeros(3))
        placements = self._bodies.placements(angles)
        found = []
        for index in suspects:
            result = coal.CollisionResult()
            request = coal.CollisionRequest()
            shape = self._bodies.bodies[index].shape
            if coal.collide(terrain.field, field_placement, shape, placements[index], request, result):
                found.append(int(index))
                if first_only:
                    break
        return found


@compiled
def _judge(
    leg: NDArray[np.float64],
    link: NDArray[np.int64],
    rows: NDArray[np.float64],
    exact: NDArray[np.bool_],
    axes: NDArray[np.float64],
    angles: NDArray[np.float64],
    heights: NDArray[np.float64],
    resolution: float,
    simplex: NDArray[np.float64],
    verdict: NDArray[np.uint8],
) -> None:  # pragma: no cover - compiled
    """Fill verdict (k, m), CLEAR at first, per configuration and body, up to the first body that surely collides."""
    highest = quad_maxima(heights)
    top = np.max(highest)
    rotations, origins = np.empty((2, 3, 3)), np.empty((2, 3))
    body, prism, directions = np.empty(ROW), np.empty(ROW), np.empty((len(rows), 2, 3))
    for m in range(len(rows)):
        directions[m, 1, 0], directions[m, 1, 1], directions[m, 1, 2] = 0.0, 0.0, 1.0
    for k in range(len(angles)):
        link_frames(leg, axes, angles[k, 0], angles[k, 1], angles[k, 2], rotations, origins)
        for m in range(len(rows)):
            row, turn, origin = rows[m], rotations[link[m]], origins[link[m]]
            # How far down the body reaches is enough for most of them, high above all terrain.
            x, y, z = turn[2, 0], turn[2, 1], turn[2, 2]
            centre = origin[2] + x * row[CENTRE] + y * row[CENTRE + 1] + z * row[CENTRE + 2]
            if centre - extent(row, x, y, z) - BAND > top:
                continue
            place(row, turn, origin, body)
            answer = body_against_terrain(body, heights, highest, resolution, prism, directions[m], simplex)
            if answer == COLLIDES and exact[m]:
                verdict[k, m] = COLLIDES
                break
            if answer != CLEAR:
                verdict[k, m] = UNDECIDED


@compiled
def body_against_terrain(
    body: NDArray[np.float64],
    heights: NDArray[np.float64],
    highest: NDArray[np.float64],
    resolution: float,
    prism: NDArray[np.float64],
    directions: NDArray[np.float64],
    simplex: NDArray[np.float64],
) -> int:  # pragma: no cover - compiled
    """CLEAR, COLLIDES or UNDECIDED for a body, a row as in `convex`, in the heading frame.

    highest: as from `quad_maxima`, in [m]. prism: (16,), directions: (2, 3) and simplex are written to.
    """
    lowest = body[CENTRE + 2] - extent(body, 0.0, 0.0, 1.0) - BAND
    quads = len(highest)
    middle, reach = body[CENTRE] / resolution + quads / 2, (extent(body, 1.0, 0.0, 0.0) + BAND) / resolution
    first_i, last_i = max(int(np.floor(middle - reach)), 0), min(int(np.floor(middle + reach)), quads - 1)
    middle, reach = body[CENTRE + 1] / resolution + quads / 2, (extent(body, 0.0, 1.0, 0.0) + BAND) / resolution
    first_j, last_j = max(int(np.floor(middle - reach)), 0), min(int(np.floor(middle + reach)), quads - 1)

    # Two directions along which the body may be apart from the terrain: upwards as seen along its longest axis, and the
    # one that cleared the last prism. Each with how far the body reaches down it.
    guess, latest = directions[0], directions[1]
    base = -np.inf
    latest_base = -np.inf
    undecided = False
    for i in range(first_i, last_i + 1):
        x = (i - quads / 2) * resolution
        for j in range(first_j, last_j + 1):
            if highest[i, j] < lowest:
                continue
            y = (j - quads / 2) * resolution
            if base == -np.inf:
                _across(body, guess)
                base = _reach_down(body, guess) - BAND
                latest_base = _reach_down(body, latest) - BAND
            h00, h01, h10, h11 = heights[i, j], heights[i, j + 1], heights[i + 1, j], heights[i + 1, j + 1]
            if _quad_reach(guess, x, y, resolution, h00, h01, h10, h11) < base:
                continue
            if _quad_reach(latest, x, y, resolution, h00, h01, h10, h11) < latest_base:
                continue
            # coal splits a quad along the diagonal from (i, j) to (i + 1, j + 1).
            for half in range(2):
                prism[0] = PRISM
                prism[1], prism[2], prism[3] = x, y, h00
                prism[4], prism[5], prism[6] = x + resolution, y + resolution, h11
                if half == 0:
                    prism[7], prism[8], prism[9] = x + resolution, y, h10
                else:
                    prism[7], prism[8], prism[9] = x, y + resolution, h01
                # Terrain goes down further than any body; a prism that ends below the body serves better.
                prism[BOTTOM] = min(lowest, h00, h11, prism[9]) - resolution
                answer = overlap(body, prism, latest, simplex)
                if answer == COLLIDES:
                    return COLLIDES
                if answer == CLEAR:
                    latest[2] = max(latest[2], 0.0)
                    latest_base = _reach_down(body, latest) - BAND
                else:
                    undecided = True
    return UNDECIDED if undecided else CLEAR


@compiled
def _across(body: NDArray[np.float64], out: NDArray[np.float64]) -> None:  # pragma: no cover - compiled
    """The unit vector perpendicular to the body's longest axis that points up the most."""
    axis = 2
    if body[0] == 0.0:
        for other in range(2):
            if body[SIZES + other] > body[SIZES + axis]:
                axis = other
    k = AXES + 3 * axis
    up = body[k + 2]
    across = np.sqrt(max(1.0 - up * up, 0.0))
    if across < 1e-3:
        out[0], out[1], out[2] = 0.0, 0.0, 1.0
    else:
        out[0], out[1], out[2] = -up * body[k] / across, -up * body[k + 1] / across, (1.0 - up * up) / across


@compiled
def _reach_down(body: NDArray[np.float64], direction: NDArray[np.float64]) -> float:  # pragma: no cover - compiled
    """The least component of the body's points along a direction, in [m]."""
    x, y, z = support(body, -direction[0], -direction[1], -direction[2])
    return float(direction[0] * x + direction[1] * y + direction[2] * z)


@compiled
def _quad_reach(
    direction: NDArray[np.float64],
    x: float,
    y: float,
    resolution: float,
    h00: float,
    h01: float,
    h10: float,
    h11: float,
) -> float:  # pragma: no cover - compiled
    """The largest component along a direction that does not point down of what lies below a quad, in [m]."""
    dx, dy, dz = direction[0] * resolution, direction[1] * resolution, direction[2]
    corners = max(dz * h00, dy + dz * h01, dx + dz * h10, dx + dy + dz * h11)
    return float(direction[0] * x + direction[1] * y + corners)


@compiled
def quad_maxima(heights: NDArray[np.float64]) -> NDArray[np.float64]:  # pragma: no cover - compiled
    """(n-1, n-1) highest corner of the quad between four cell centres."""
    rows, columns = heights.shape
    highest = np.empty((rows - 1, columns - 1))
    for i in range(rows - 1):
        for j in range(columns - 1):
            highest[i, j] = max(heights[i, j], heights[i + 1, j], heights[i, j + 1], heights[i + 1, j + 1])
    return highest
