"""Local maps of many legs in one pass over the elevation map: `ElevationMap.sample`, for less than a network costs.

A plain reference is `terrain.extract_local_map`, leg by leg. Here legs share every numpy call, heights are blended in
float32, and the treatment of borders and holes is paid for only where they are met.
"""

import numpy as np
from numpy.typing import NDArray

from footsel.terrain import CELLS, ElevationMap

#: Cell centres of a local map along one axis, from its middle, in [cells].
OFFSETS = np.arange(CELLS) - (CELLS - 1) / 2

#: (4, 1601) what the index of a point is made of, the cells of a local map and one point of its leg: steps along H's x,
#: steps along its y, the index of M_i, the index of that point.
_MAKE_UP = np.zeros((4, CELLS * CELLS + 1))
_MAKE_UP[0, :-1], _MAKE_UP[1, :-1] = np.repeat(OFFSETS, CELLS), np.tile(OFFSETS, CELLS)
_MAKE_UP[2, :-1] = _MAKE_UP[3, -1] = 1
#: A local map is a rectangle: where its corners are on the map, all of it is. Its leg's point comes last.
_EXTREMES = np.array([0, CELLS - 1, CELLS * (CELLS - 1), CELLS * CELLS - 1, CELLS * CELLS])


def sample_legs(
    elevation_map: ElevationMap,
    hips: NDArray[np.float64],
    heading: NDArray[np.float64],
    side: NDArray[np.float64],
    points: NDArray[np.float64],
    resolution: float,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Local maps (m, 40, 40) of heights relative to the hip points, and heights (m,) at a point of each leg.

    hips: (m, 3) hip points L_i in the world frame, in [m].
    heading: (m, 2) cosine and sine of the base's yaw.
    side: (m,) -1 for legs whose map is turned round along y, as their mirror image would see it; else 1.
    points: (m, 2) world points, in [m].
    resolution: side of a local map's cell, in [m].
    Heights in [m], NaN = unknown.
    """
    nx, ny = elevation_map.shape
    m = len(hips)
    places = np.concatenate((hips[:, :2], points))
    places -= elevation_map.position
    places /= elevation_map.resolution
    places += ((nx - 1) / 2, (ny - 1) / 2)
    step = heading * (resolution / elevation_map.resolution)  # (m, 2) map cells per cell along H's x
    parts = np.empty((m, 2, 4))  # of u and v
    parts[:, :, 0] = step
    np.multiply(step[:, 1], -side, out=parts[:, 0, 1])
    np.multiply(step[:, 0], side, out=parts[:, 1, 1])
    parts[:, :, 2], parts[:, :, 3] = places[:m], places[m:]

    heights = _sample(elevation_map, (parts.reshape(-1, 4) @ _MAKE_UP).reshape(m, 2, -1))
    local = heights[:, :-1] - hips[:, 2, None].astype(np.float32)
    return local.reshape(m, CELLS, CELLS), heights[:, -1]


def _sample(elevation_map: ElevationMap, index: NDArray[np.float64]) -> NDArray[np.float32]:
    """(m, 1601) heights at indices u and v (m, 2, 1601) of the cells of rectangles and a point each."""
    nx, ny = elevation_map.shape
    u, v = (along.ravel().tolist() for along in index.take(_EXTREMES, axis=2).swapaxes(0, 1))
    inside = None
    if min(u) < 0 or min(v) < 0 or max(u) >= nx - 1 or max(v) >= ny - 1:
        most = np.array([nx, ny])[:, None]
        inside = ((index + 0.5 >= 0) & (index + 0.5 < most)).all(axis=1)
        index = np.clip(index, 0, most - 1)
        first = np.minimum(np.floor(index), most - 2)
    else:
        first = np.floor(index)
    share = (index - first).astype(np.float32)
    share_u, share_v = share[:, 0], share[:, 1]

    flat = elevation_map.elevation.reshape(-1)
    at = (first[:, 0] * ny + first[:, 1]).astype(np.intp)
    low, low_next = flat.take(at), flat[1:].take(at)
    high, high_next = flat[ny:].take(at), flat[ny + 1 :].take(at)
    # Differences of absurd heights leave float32; as what is unknown, they are worked out once more below.
    with np.errstate(over="ignore", invalid="ignore"):
        heights = _blend(_blend(low, low_next, share_v), _blend(high, high_next, share_v), share_u)

    sound = np.isfinite(heights)
    if not sound.all():
        holes = ~sound
        u, v = index.swapaxes(0, 1)[:, holes]
        heights[holes] = _beside_unknown(flat, ny, at[holes], u - first[:, 0][holes], v - first[:, 1][holes])
    if inside is not None:
        heights[~inside] = np.nan
    return heights


def _blend(start: NDArray[np.float32], end: NDArray[np.float32], share: NDArray[np.float32]) -> NDArray[np.float32]:
    """start + share * (end - start), in the memory of `end`."""
    end -= start
    end *= share
    end += start
    return end


def _beside_unknown(
    flat: NDArray[np.float32], ny: int, at: NDArray[np.intp], a: NDArray[np.float64], b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(p,) heights at points with an unknown neighbour: the known ones share its weight; NaN if the nearest is unknown.

    flat: the map's cells, rows of `ny` in one row. at: (p,) the first of the four cells around each point.
    a, b: (p,) how far beyond that cell a point lies along x and y, in [cells].
    """
    heights = flat[at + np.array([0, 1, ny, ny + 1])[:, None]]
    weights = np.stack([(1 - a) * (1 - b), (1 - a) * b, a * (1 - b), a * b])
    unknown = np.isnan(heights)
    nearest = 2 * (a >= 0.5) + (b >= 0.5)
    known = ~unknown[nearest, np.arange(len(nearest))]
    weights[unknown] = 0
    heights[unknown] = 0
    # A known nearest cell has weight, so no known point divides by zero.
    total = np.where(known, weights.sum(axis=0), np.nan)
    return np.asarray((weights * heights).sum(axis=0) / total)
