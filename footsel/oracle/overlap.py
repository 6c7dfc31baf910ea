"""Do two convex bodies overlap? An answer with proof, or none.

Gilbert, Johnson and Keerthi (1988) search the difference of two bodies, all vectors from a point of the second to a
point of the first, for the origin, with a simplex of such vectors. What is answered is proved by what was found: a
direction along which the bodies are more than BAND apart (CLEAR), or a tetrahedron in the difference, or two on one
face, with the origin deeper than BAND below each outer face (COLLIDES). Rounding can cost an answer and not make a
wrong one. Pairs nearer to touching than BAND, and the few for which an edge of the simplex passes through the origin,
are UNDECIDED.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.compiled import compiled
from footsel.oracle.convex import support

CLEAR, COLLIDES, UNDECIDED = 0, 1, 2

#: Ten times what coal's own search leaves open. [m]
BAND = 1e-5

#: Three or four steps are the rule; round bodies that almost touch take more.
MAX_STEPS = 32


def workspace() -> NDArray[np.float64]:
    """What `overlap` writes its simplex to: points, and the weights of the point nearest to the origin."""
    return np.empty((4, 4))


@compiled
def overlap(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    direction: NDArray[np.float64],
    simplex: NDArray[np.float64],
) -> int:  # pragma: no cover - compiled
    """CLEAR, COLLIDES or UNDECIDED for two bodies, rows as in `convex`.

    direction: (3,) guess of a direction from the second body to the first along which they are apart; if they are, it
    becomes such a unit vector. simplex: a `workspace`.
    """
    x, y, z = direction[0], direction[1], direction[2]
    answer = _search(first, second, x, y, z, direction, simplex)
    if answer == UNDECIDED:
        # Symmetric bodies easily have the origin on an edge of the simplex; from an odd direction they hardly do.
        odd = 0.1 * (abs(x) + abs(y) + abs(z))
        x, y, z = 0.48 * x - 0.6 * y + 0.64 * z + odd, 0.8 * z + 0.6 * x, 0.7 * y - 0.3 * z
        answer = _search(first, second, x, y, z, direction, simplex)
    return answer


@compiled
def _search(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    x: float,
    y: float,
    z: float,
    direction: NDArray[np.float64],
    simplex: NDArray[np.float64],
) -> int:  # pragma: no cover - compiled
    """As `overlap`, beginning with the direction (x, y, z)."""
    count = 0
    for _ in range(MAX_STEPS):
        ax, ay, az = support(first, -x, -y, -z)
        bx, by, bz = support(second, x, y, z)
        wx, wy, wz = ax - bx, ay - by, az - bz
        gap, length = wx * x + wy * y + wz * z, np.sqrt(x * x + y * y + z * z)
        if gap > BAND * length:
            direction[0], direction[1], direction[2] = x / length, y / length, z / length
            return CLEAR
        for k in range(count):
            if simplex[k, 0] == wx and simplex[k, 1] == wy and simplex[k, 2] == wz:
                return UNDECIDED  # Nothing is nearer to the origin than what is known.
        simplex[count, 0], simplex[count, 1], simplex[count, 2] = wx, wy, wz
        count += 1
        if count == 4 and _holds_origin(simplex):
            return COLLIDES
        count = _keep_nearest(simplex, count)
        x = y = z = 0.0
        for k in range(count):
            x += simplex[k, 3] * simplex[k, 0]
            y += simplex[k, 3] * simplex[k, 1]
            z += simplex[k, 3] * simplex[k, 2]
        if count == 3 and x * x + y * y + z * z < BAND * BAND:
            return _through_triangle(first, second, simplex)
        if count == 4 or x * x + y * y + z * z < BAND * BAND:
            return UNDECIDED
    return UNDECIDED


@compiled
def _through_triangle(
    first: NDArray[np.float64], second: NDArray[np.float64], s: NDArray[np.float64]
) -> int:  # pragma: no cover - compiled
    """With the origin on the simplex's triangle, or nearer than BAND: COLLIDES if the difference is wide on both sides.

    It is then deeper than BAND below the outer faces of two tetrahedra on this triangle, so inside one or the other.
    """
    ux, uy, uz = s[1, 0] - s[0, 0], s[1, 1] - s[0, 1], s[1, 2] - s[0, 2]
    vx, vy, vz = s[2, 0] - s[0, 0], s[2, 1] - s[0, 1], s[2, 2] - s[0, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length == 0.0:
        return UNDECIDED
    for sign in (1.0, -1.0):
        x, y, z = sign * nx / length, sign * ny / length, sign * nz / length
        ax, ay, az = support(first, x, y, z)
        bx, by, bz = support(second, -x, -y, -z)
        s[3, 0], s[3, 1], s[3, 2] = ax - bx, ay - by, az - bz
        if not (s[3, 0] - s[0, 0]) * x + (s[3, 1] - s[0, 1]) * y + (s[3, 2] - s[0, 2]) * z > 2 * BAND:
            return UNDECIDED
        for d in range(3):
            if not _depth(s, (d + 1) % 3, (d + 2) % 3, 3, d) > BAND:
                return UNDECIDED
    return COLLIDES


@compiled
def _depth(s: NDArray[np.float64], a: int, b: int, c: int, d: int) -> float:  # pragma: no cover - compiled
    """Height of the origin over the plane of a, b, c, positive on the side of d; NaN for a flat tetrahedron."""
    ux, uy, uz = s[b, 0] - s[a, 0], s[b, 1] - s[a, 1], s[b, 2] - s[a, 2]
    vx, vy, vz = s[c, 0] - s[a, 0], s[c, 1] - s[a, 1], s[c, 2] - s[a, 2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    here = -(nx * s[a, 0] + ny * s[a, 1] + nz * s[a, 2])
    there = nx * (s[d, 0] - s[a, 0]) + ny * (s[d, 1] - s[a, 1]) + nz * (s[d, 2] - s[a, 2])
    if length == 0.0 or there == 0.0:
        return np.nan
    return float(here / length if there > 0.0 else -here / length)


@compiled
def _holds_origin(s: NDArray[np.float64]) -> bool:  # pragma: no cover - compiled
    """Whether the origin is deeper than BAND inside the tetrahedron."""
    for d in range(4):  # noqa: SIM110 (compiled)
        if not _depth(s, (d + 1) % 4, (d + 2) % 4, (d + 3) % 4, d) > BAND:
            return False
    return True


@compiled
def _keep_nearest(s: NDArray[np.float64], count: int) -> int:  # pragma: no cover - compiled
    """Reduce the simplex to the points that span its point nearest to the origin, and give these their weights.

    Returns how many are left; four if the origin is inside.
    """
    if count == 1:
        s[0, 3] = 1.0
        return 1
    if count == 2:
        s[0, 3], s[1, 3] = _on_segment(s)
    elif count == 3:
        s[0, 3], s[1, 3], s[2, 3], _ = _on_triangle(s, 0, 1, 2)
    else:
        least = np.inf
        wa = wb = wc = 0.0
        without = -1
        for d in range(4):
            a, b, c = (d + 1) % 4, (d + 2) % 4, (d + 3) % 4
            if _depth(s, a, b, c, d) > 0.0:
                continue  # The origin is on the inner side of this face.
            fa, fb, fc, square = _on_triangle(s, a, b, c)
            if square < least:
                least, without, wa, wb, wc = square, d, fa, fb, fc
        if without < 0:
            return 4
        s[(without + 1) % 4, 3], s[(without + 2) % 4, 3], s[(without + 3) % 4, 3] = wa, wb, wc
        s[without, 3] = 0.0
    left = 0
    for k in range(count):
        if s[k, 3] > 0.0:
            for i in range(4):
                s[left, i] = s[k, i]
            left += 1
    return left


@compiled
def _on_segment(s: NDArray[np.float64]) -> tuple[float, float]:  # pragma: no cover - compiled
    """Weights of the two ends for the segment's point nearest to the origin."""
    ux, uy, uz = s[1, 0] - s[0, 0], s[1, 1] - s[0, 1], s[1, 2] - s[0, 2]
    along = -(ux * s[0, 0] + uy * s[0, 1] + uz * s[0, 2])
    square = ux * ux + uy * uy + uz * uz
    share = 0.0 if along <= 0.0 else 1.0 if along >= square else along / square
    return 1.0 - share, share


@compiled
def _on_triangle(
    s: NDArray[np.float64], a: int, b: int, c: int
) -> tuple[float, float, float, float]:  # pragma: no cover - compiled
    """Weights of three corners for the triangle's point nearest to the origin, and its square distance.

    The origin is in the region of a corner, of an edge or of the face (Ericson 2004, Real-Time Collision Detection).
    """
    ux, uy, uz = s[b, 0] - s[a, 0], s[b, 1] - s[a, 1], s[b, 2] - s[a, 2]
    vx, vy, vz = s[c, 0] - s[a, 0], s[c, 1] - s[a, 1], s[c, 2] - s[a, 2]
    au, av = -(ux * s[a, 0] + uy * s[a, 1] + uz * s[a, 2]), -(vx * s[a, 0] + vy * s[a, 1] + vz * s[a, 2])
    bu, bv = -(ux * s[b, 0] + uy * s[b, 1] + uz * s[b, 2]), -(vx * s[b, 0] + vy * s[b, 1] + vz * s[b, 2])
    cu, cv = -(ux * s[c, 0] + uy * s[c, 1] + uz * s[c, 2]), -(vx * s[c, 0] + vy * s[c, 1] + vz * s[c, 2])
    over_ab, over_ac, over_bc = au * bv - bu * av, cu * av - au * cv, bu * cv - cu * bv
    if au <= 0.0 and av <= 0.0:
        wa, wb, wc = 1.0, 0.0, 0.0
    elif bu >= 0.0 and bv <= bu:
        wa, wb, wc = 0.0, 1.0, 0.0
    elif cv >= 0.0 and cu <= cv:
        wa, wb, wc = 0.0, 0.0, 1.0
    elif over_ab <= 0.0 and au >= 0.0 and bu <= 0.0:
        wb = au / (au - bu)
        wa, wc = 1.0 - wb, 0.0
    elif over_ac <= 0.0 and av >= 0.0 and cv <= 0.0:
        wc = av / (av - cv)
        wa, wb = 1.0 - wc, 0.0
    elif over_bc <= 0.0 and bv >= bu and cu >= cv:
        wc = (bv - bu) / ((bv - bu) + (cu - cv))
        wa, wb = 0.0, 1.0 - wc
    else:
        total = over_ab + over_ac + over_bc
        wb, wc = over_ac / total, over_ab / total
        wa = 1.0 - wb - wc
    x = wa * s[a, 0] + wb * s[b, 0] + wc * s[c, 0]
    y = wa * s[a, 1] + wb * s[b, 1] + wc * s[c, 1]
    z = wa * s[a, 2] + wb * s[b, 2] + wc * s[c, 2]
    return wa, wb, wc, x * x + y * y + z * z
