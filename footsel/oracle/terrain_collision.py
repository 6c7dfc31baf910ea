"""The third constraint: does the leg touch the terrain anywhere but at its foot?

Terrain is the solid below the triangulated heights of the known cells; unknown cells collide with nothing. Cover
spheres of the leg's bodies settle most cells, all clear of the terrain or one with its centre below it; then points of
the bodies' skin below the terrain settle half of the rest. What is left goes to coal.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import coal
import numba
import numpy as np
from numpy.typing import NDArray

from footsel.oracle.swing_bodies import SwingBodies
from footsel.robot.leg_kinematics import link_frames

CLEAR, COLLIDES, UNDECIDED = 0, 1, 2

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
    def field(self) -> Any:
        """coal's height field: rows run along -y, columns along +x, values are vertices at cell centres."""
        side = (len(self.heights) - 1) * self.resolution
        filled = np.where(np.isnan(self.heights), self.floor, self.heights)
        return coal.HeightFieldOBBRSS(side, side, np.asfortranarray(filled.T[::-1]), self.floor)


class TerrainCollision:
    """Terrain collision of one leg."""

    def __init__(self, bodies: SwingBodies) -> None:
        self._bodies = bodies

    def check(self, terrain: Terrain, tilt: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(k,) whether the leg collides at angles (k, 3); tilt: (3, 3) rotation from base to heading frame."""
        verdict = np.empty((len(angles), len(self._bodies.bodies)), dtype=np.uint8)
        known = np.where(np.isnan(terrain.heights), -np.inf, terrain.heights)
        _screen(
            self._bodies.leg,
            self._bodies.link,
            self._bodies.spheres,
            self._bodies.skin,
            tilt,
            np.ascontiguousarray(angles),
            known,
            terrain.resolution,
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


@numba.njit(cache=True)
def _screen(
    leg: NDArray[np.float64],
    link: NDArray[np.int64],
    spheres: NDArray[np.float64],
    skin: NDArray[np.float64],
    tilt: NDArray[np.float64],
    angles: NDArray[np.float64],
    heights: NDArray[np.float64],
    resolution: float,
    verdict: NDArray[np.uint8],
) -> None:  # pragma: no cover - compiled
    """Fill verdict (k, m) per configuration and body; after a certain hit the leg's other bodies are left CLEAR."""
    highest = _quad_maxima(heights)
    top = np.max(highest)
    rotations, origins = np.empty((2, 3, 3)), np.empty((2, 3))
    in_heading, start = np.empty((2, 3, 3)), np.empty((2, 3))
    for row in range(len(angles)):
        verdict[row, :] = CLEAR
        link_frames(leg, angles[row, 0], angles[row, 1], angles[row, 2], rotations, origins)
        for part in range(2):
            for i in range(3):
                start[part, i] = (
                    tilt[i, 0] * origins[part, 0] + tilt[i, 1] * origins[part, 1] + tilt[i, 2] * origins[part, 2]
                )
                for j in range(3):
                    in_heading[part, i, j] = (
                        tilt[i, 0] * rotations[part, 0, j]
                        + tilt[i, 1] * rotations[part, 1, j]
                        + tilt[i, 2] * rotations[part, 2, j]
                    )
        for index in range(len(spheres)):
            body = int(spheres[index, 0])
            if verdict[row, body] == UNDECIDED and index % 2 == 1:
                # The body goes to coal anyway; every other sphere still looks for a certain hit.
                continue
            part = link[body]
            turn = in_heading[part]
            a, b, c, radius = spheres[index, 1], spheres[index, 2], spheres[index, 3], spheres[index, 4]
            z = start[part, 2] + turn[2, 0] * a + turn[2, 1] * b + turn[2, 2] * c
            if z - radius > top:
                continue
            x = start[part, 0] + turn[0, 0] * a + turn[0, 1] * b + turn[0, 2] * c
            y = start[part, 1] + turn[1, 0] * a + turn[1, 1] * b + turn[1, 2] * c
            answer = _sphere_against_terrain(x, y, z, radius, heights, highest, resolution)
            if answer == COLLIDES:
                verdict[row, :] = CLEAR
                verdict[row, body] = COLLIDES
                break
            if answer == UNDECIDED:
                verdict[row, body] = UNDECIDED
        if (verdict[row] == UNDECIDED).any():
            body = _skin_below_terrain(link, skin, verdict[row], in_heading, start, heights, resolution)
            if body >= 0:
                verdict[row, :] = CLEAR
                verdict[row, body] = COLLIDES


@numba.njit(cache=True)
def _skin_below_terrain(
    link: NDArray[np.int64],
    skin: NDArray[np.float64],
    verdict: NDArray[np.uint8],
    in_heading: NDArray[np.float64],
    start: NDArray[np.float64],
    heights: NDArray[np.float64],
    resolution: float,
) -> int:  # pragma: no cover - compiled
    """The first undecided body with a point of its skin below the terrain, -1 for none."""
    for index in range(len(skin)):
        body = int(skin[index, 0])
        if verdict[body] != UNDECIDED:
            continue
        part = link[body]
        turn = in_heading[part]
        a, b, c = skin[index, 1], skin[index, 2], skin[index, 3]
        x = start[part, 0] + turn[0, 0] * a + turn[0, 1] * b + turn[0, 2] * c
        y = start[part, 1] + turn[1, 0] * a + turn[1, 1] * b + turn[1, 2] * c
        z = start[part, 2] + turn[2, 0] * a + turn[2, 1] * b + turn[2, 2] * c
        if _below_terrain(x, y, z, heights, resolution):
            return body
    return -1


@numba.njit(cache=True)
def _quad_maxima(heights: NDArray[np.float64]) -> NDArray[np.float64]:  # pragma: no cover - compiled
    """(n-1, n-1) highest corner of the quad between four cell centres."""
    rows, columns = heights.shape
    highest = np.empty((rows - 1, columns - 1))
    for i in range(rows - 1):
        for j in range(columns - 1):
            highest[i, j] = max(heights[i, j], heights[i + 1, j], heights[i, j + 1], heights[i + 1, j + 1])
    return highest


@numba.njit(cache=True)
def _sphere_against_terrain(
    x: float,
    y: float,
    z: float,
    radius: float,
    heights: NDArray[np.float64],
    highest: NDArray[np.float64],
    resolution: float,
) -> int:  # pragma: no cover - compiled
    """COLLIDES if the centre is below its quad's lowest corner, CLEAR if the sphere misses every quad's column."""
    if _below_terrain(x, y, z, heights, resolution):
        return COLLIDES
    quads = len(highest)
    fx, fy = x / resolution + quads / 2, y / resolution + quads / 2
    reach = radius / resolution
    for i in range(max(int(np.floor(fx - reach)), 0), min(int(np.floor(fx + reach)), quads - 1) + 1):
        dx = max(i - fx, fx - i - 1, 0.0) * resolution
        for j in range(max(int(np.floor(fy - reach)), 0), min(int(np.floor(fy + reach)), quads - 1) + 1):
            if z - radius > highest[i, j]:
                continue
            dy = max(j - fy, fy - j - 1, 0.0) * resolution
            dz = max(z - highest[i, j], 0.0)
            if dx * dx + dy * dy + dz * dz <= radius * radius:
                return UNDECIDED
    return CLEAR


@numba.njit(cache=True)
def _below_terrain(
    x: float, y: float, z: float, heights: NDArray[np.float64], resolution: float
) -> bool:  # pragma: no cover - compiled
    """Whether a point is below the lowest corner of its quad, so inside the solid however the quad is split."""
    quads = len(heights) - 1
    i, j = int(np.floor(x / resolution + quads / 2)), int(np.floor(y / resolution + quads / 2))
    if not (0 <= i < quads and 0 <= j < quads):
        return False
    return bool(z < min(heights[i, j], heights[i + 1, j], heights[i, j + 1], heights[i + 1, j + 1]))
