"""The second constraint: does the swing leg touch the base or another leg at its nominal stance?

Which bodies touch depends on the three joint angles alone. A table over the joint angles answers where all nodes around
a configuration agree, one node beyond its own box included; elsewhere the bodies themselves are compared. Indexed by
joint angles, the table serves every base tilt, terrain height and cell size.
"""

from dataclasses import dataclass

import coal
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from tqdm import tqdm

from footsel.compiled import compiled
from footsel.oracle.convex import AXES, CENTRE, extent, place, placed, shape_row
from footsel.oracle.overlap import BAND, CLEAR, COLLIDES, UNDECIDED, overlap, workspace
from footsel.oracle.swing_bodies import SwingBodies
from footsel.robot.leg_kinematics import link_frames
from footsel.robot.robot import Robot

#: Distance between fine nodes of the table; the foot moves by 1.5 cm at most between them. [rad]
NODE_STEP = 0.025

#: Nodes are judged in batches of this size, beside a progress bar.
BATCH = 2000

#: Beside COLLIDES and UNDECIDED: no pair touches.
FREE = CLEAR


class ExactSelfCollision:
    """Self-collision of one leg: the swing leg's bodies against base and other legs at the nominal stance.

    Pairs nearer to touching than a hundredth of a millimetre are put to coal.
    """

    def __init__(self, robot: Robot, leg: str) -> None:
        bodies = robot.bodies[leg]
        self._swing = SwingBodies.of(robot, leg, bodies.swing)
        self._obstacles = bodies.obstacles
        self._pairs = np.array(bodies.pairs, dtype=np.int64).reshape(-1, 2)
        hip = robot.kinematics[leg].hip
        self._transforms = [coal.Transform3s(o.rotation, o.translation - hip) for o in bodies.obstacles]
        shapes = [shape_row(obstacle.shape) for obstacle in bodies.obstacles]
        self._standing = np.array(
            [placed(row, o.rotation, o.translation - hip) for (row, _), o in zip(shapes, bodies.obstacles, strict=True)]
        )
        exact = np.array([is_exact for _, is_exact in shapes])
        self._exact = self._swing.exact[self._pairs[:, 0]] & exact[self._pairs[:, 1]]

    def check(self, angles: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(k,) whether any allowed pair touches with the leg at angles (k, 3), in [rad]."""
        verdict = self._verdict(angles, first_only=True)
        collides: NDArray[np.bool_] = (verdict == COLLIDES).any(axis=1)
        for k in np.flatnonzero(~collides & (verdict == UNDECIDED).any(axis=1)):
            collides[k] = bool(self._ask(angles[k], np.flatnonzero(verdict[k] == UNDECIDED)))
        return collides

    def collides(self, angles: ArrayLike) -> bool:
        """Whether any allowed pair touches with the leg at `angles` (3,), in [rad]."""
        return bool(self.check(np.asarray(angles, dtype=np.float64).reshape(1, 3))[0])

    def touching(self, angles: ArrayLike) -> list[tuple[str, str]]:
        """Names of all pairs of bodies, swing leg's first, that coal finds touching at `angles` (3,), in [rad]."""
        q = np.asarray(angles, dtype=np.float64)
        (verdict,) = self._verdict(q.reshape(1, 3), first_only=False)
        touching = self._pairs[self._ask(q, np.flatnonzero(verdict != CLEAR))]
        return [(self._swing.bodies[i].name, self._obstacles[j].name) for i, j in touching]

    def _verdict(self, angles: NDArray[np.float64], first_only: bool) -> NDArray[np.uint8]:
        """(k, p) CLEAR, COLLIDES or UNDECIDED per configuration and pair; with `first_only` the pairs after a collision
        are left CLEAR."""
        swing = self._swing
        verdict = np.zeros((len(angles), len(self._pairs)), dtype=np.uint8)
        _judge(
            swing.leg,
            swing.axes,
            swing.link,
            swing.rows,
            self._standing,
            self._pairs,
            self._exact,
            np.ascontiguousarray(angles),
            first_only,
            workspace(),
            verdict,
        )
        return verdict

    def _ask(self, angles: NDArray[np.float64], pairs: NDArray[np.intp]) -> list[int]:
        """Which of the pairs, by index, coal finds touching.

        Every pair is asked with a fresh request and result: coal's reusable ones, which Pinocchio's computeCollisions
        holds, carry a guess from the last question and now and then miss an overlap of a centimetre because of it.
        """
        placements = self._swing.placements(angles)
        found = []
        for pair in pairs.tolist():
            i, j = self._pairs[pair]
            shape, obstacle = self._swing.bodies[i].shape, self._obstacles[j].shape
            result = coal.CollisionResult()
            if coal.collide(shape, placements[i], obstacle, self._transforms[j], coal.CollisionRequest(), result):
                found.append(pair)
        return found


@compiled
def _judge(
    leg: NDArray[np.float64],
    axes: NDArray[np.float64],
    link: NDArray[np.int64],
    rows: NDArray[np.float64],
    standing: NDArray[np.float64],
    pairs: NDArray[np.int64],
    exact: NDArray[np.bool_],
    angles: NDArray[np.float64],
    first_only: bool,
    simplex: NDArray[np.float64],
    verdict: NDArray[np.uint8],
) -> None:  # pragma: no cover - compiled
    """Fill verdict (k, p), CLEAR at first, as `ExactSelfCollision._verdict` says."""
    rotations, origins = np.empty((2, 3, 3)), np.empty((2, 3))
    swing_boxes, boxes = _boxes(rows), _boxes(standing)
    swing_radii, radii = _radii(swing_boxes), _radii(boxes)
    bodies, nearest, directions = np.empty(rows.shape), np.empty(3), np.zeros((len(pairs), 3))
    for k in range(len(angles)):
        link_frames(leg, axes, angles[k, 0], angles[k, 1], angles[k, 2], rotations, origins)
        for m in range(len(rows)):
            place(rows[m], rotations[link[m]], origins[link[m]], bodies[m])
        for pair in range(len(pairs)):
            i, j = pairs[pair, 0], pairs[pair, 1]
            reach, square = swing_radii[i] + BAND, 0.0
            for axis in range(CENTRE, CENTRE + 3):
                square += (bodies[i, axis] - standing[j, axis]) ** 2
            if square > (reach + radii[j]) ** 2 or _from_box(standing[j], boxes[j], bodies[i], nearest) > reach:
                continue
            # What kept a pair apart at the last configuration mostly does again.
            direction = directions[pair]
            if direction[0] == 0.0 and direction[1] == 0.0 and direction[2] == 0.0:
                direction[0], direction[1], direction[2] = nearest[0], nearest[1], nearest[2]
            answer = overlap(bodies[i], standing[j], direction, simplex)
            verdict[k, pair] = answer if exact[pair] or answer == CLEAR else UNDECIDED
            if first_only and verdict[k, pair] == COLLIDES:
                break


@compiled
def _radii(boxes: NDArray[np.float64]) -> NDArray[np.float64]:  # pragma: no cover - compiled
    """(m,) radius of a sphere that holds a box of half sides (m, 3), in [m]."""
    radii = np.empty(len(boxes))
    for m in range(len(boxes)):
        radii[m] = np.sqrt(boxes[m, 0] ** 2 + boxes[m, 1] ** 2 + boxes[m, 2] ** 2)
    return radii


@compiled
def _boxes(rows: NDArray[np.float64]) -> NDArray[np.float64]:  # pragma: no cover - compiled
    """(m, 3) half sides along its own axes of a box that holds each body, in [m]."""
    boxes = np.empty((len(rows), 3))
    for m in range(len(rows)):
        for axis in range(3):
            k = AXES + 3 * axis
            boxes[m, axis] = extent(rows[m], rows[m, k], rows[m, k + 1], rows[m, k + 2])
    return boxes


@compiled
def _from_box(
    standing: NDArray[np.float64],
    half_sides: NDArray[np.float64],
    body: NDArray[np.float64],
    direction: NDArray[np.float64],
) -> float:  # pragma: no cover - compiled
    """Distance from a standing body's box to the centre of another; `direction` becomes the way there, never zero."""
    x, y = body[CENTRE] - standing[CENTRE], body[CENTRE + 1] - standing[CENTRE + 1]
    z = body[CENTRE + 2] - standing[CENTRE + 2]
    direction[0] = direction[1] = direction[2] = 0.0
    square = 0.0
    for axis in range(3):
        k = AXES + 3 * axis
        along = standing[k] * x + standing[k + 1] * y + standing[k + 2] * z
        outside = max(along - half_sides[axis], 0.0) + min(along + half_sides[axis], 0.0)
        square += outside * outside
        for i in range(3):
            direction[i] += outside * standing[k + i]
    if square < BAND * BAND:
        direction[0], direction[1], direction[2] = x, y, z + BAND
    return float(np.sqrt(square))


@dataclass(frozen=True, eq=False)
class SelfCollisionTable:
    """What is certain in each box of a grid over the joint limits.

    answer: (a, b, c) uint8 FREE, COLLIDES or UNDECIDED.
    low: (3,) angles of the first corner, step: (3,) sides of a box, in [rad].
    """

    answer: NDArray[np.uint8]
    low: NDArray[np.float64]
    step: NDArray[np.float64]

    @classmethod
    def build(cls, robot: Robot, leg: str) -> "SelfCollisionTable":
        """Judge coarse nodes, then fine nodes near where coarse ones differ, some 400,000 in all."""
        exact = ExactSelfCollision(robot, leg)
        limits = robot.kinematics[leg].limits
        coarse_boxes = np.ceil((limits[:, 1] - limits[:, 0]) / (2 * NODE_STEP)).astype(int)
        axes = [np.linspace(low, high, 2 * n + 1) for (low, high), n in zip(limits, coarse_boxes, strict=True)]
        nodes = np.zeros(2 * coarse_boxes + 1, dtype=np.bool_)

        def ask(which: NDArray[np.bool_], what: str) -> None:
            indices = np.argwhere(which)
            parts = np.array_split(indices, len(indices) // BATCH + 1)
            for part in tqdm(parts, desc=f"{leg} self-collision, {what}", leave=False, disable=None):
                nodes[tuple(part.T)] = exact.check(np.column_stack([axes[k][part[:, k]] for k in range(3)]))

        coarse = np.zeros(nodes.shape, dtype=np.bool_)
        coarse[::2, ::2, ::2] = True
        ask(coarse, "coarse nodes")
        corners = nodes[::2, ::2, ::2]
        # Boxes whose corners differ, and their neighbours, are asked again at half the step.
        refined = ndimage.binary_dilation(_box_differs(corners), np.ones((3, 3, 3)))
        fine = np.zeros(nodes.shape, dtype=np.bool_)
        grown = np.repeat(np.repeat(np.repeat(refined, 2, 0), 2, 1), 2, 2)
        for offset in np.ndindex(2, 2, 2):
            fine[tuple(slice(o, o + n) for o, n in zip(offset, grown.shape, strict=True))] |= grown
        inherited = np.repeat(np.repeat(np.repeat(corners, 2, 0), 2, 1), 2, 2)[:-1, :-1, :-1]
        nodes[:] = inherited
        ask(fine, "fine nodes")

        differs = ndimage.binary_dilation(_box_differs(nodes), np.ones((3, 3, 3)))
        answer = np.where(nodes[:-1, :-1, :-1], COLLIDES, FREE)
        answer[differs] = UNDECIDED
        return cls(answer.astype(np.uint8), limits[:, 0].copy(), (limits[:, 1] - limits[:, 0]) / answer.shape)

    def look_up(self, angles: NDArray[np.float64]) -> NDArray[np.uint8]:
        """(n,) FREE, COLLIDES or UNDECIDED for angles (n, 3) within the limits."""
        return _look_up(self.answer, self.low, self.step, np.ascontiguousarray(angles))


def _box_differs(nodes: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(a-1, b-1, c-1) boxes whose eight corners are not all alike."""
    total = np.zeros([n - 1 for n in nodes.shape], dtype=np.uint8)
    for offset in np.ndindex(2, 2, 2):
        total += nodes[tuple(slice(o, o + n) for o, n in zip(offset, total.shape, strict=True))]
    return (total > 0) & (total < 8)


@compiled
def _look_up(
    answer: NDArray[np.uint8], low: NDArray[np.float64], step: NDArray[np.float64], angles: NDArray[np.float64]
) -> NDArray[np.uint8]:  # pragma: no cover - compiled
    """The table's answer for the box that holds each row of angles."""
    answers = np.empty(len(angles), dtype=np.uint8)
    for row in range(len(angles)):
        a = min(max(int((angles[row, 0] - low[0]) / step[0]), 0), answer.shape[0] - 1)
        b = min(max(int((angles[row, 1] - low[1]) / step[1]), 0), answer.shape[1] - 1)
        c = min(max(int((angles[row, 2] - low[2]) / step[2]), 0), answer.shape[2] - 1)
        answers[row] = answer[a, b, c]
    return answers
