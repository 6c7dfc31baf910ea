"""The second constraint: does the swing leg touch the base or another leg at its nominal stance?

Which bodies touch depends on the three joint angles alone. A table over the joint angles answers where all nodes around
a configuration agree, one node beyond its own box included; elsewhere the question goes to coal. Indexed by joint
angles, the table serves every base tilt, terrain height and cell size.
"""

from dataclasses import dataclass

import coal
import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from tqdm import tqdm

from footsel.oracle.swing_bodies import SwingBodies
from footsel.robot.leg_kinematics import link_frames
from footsel.robot.robot import Robot

#: Distance between fine nodes of the table; the foot moves by 1.5 cm at most between them. [rad]
NODE_STEP = 0.025

FREE, COLLIDES, UNDECIDED = 0, 1, 2


class ExactSelfCollision:
    """Direct question to coal for one leg: the swing leg's bodies against base and other legs at the nominal stance.

    Every pair is asked with a fresh request and result: coal's reusable ones, which Pinocchio's computeCollisions
    holds, carry a guess from the last question and now and then miss an overlap of a centimetre because of it.
    """

    def __init__(self, robot: Robot, leg: str) -> None:
        bodies = robot.bodies[leg]
        self._swing = SwingBodies.of(robot, leg, bodies.swing)
        self._obstacles = bodies.obstacles
        hip = robot.kinematics[leg].hip
        self._transforms = [coal.Transform3s(o.rotation, o.translation - hip) for o in bodies.obstacles]
        boxes = []
        for body in bodies.obstacles:
            body.shape.computeLocalAABB()
            box = body.shape.aabb_local
            boxes.append(np.concatenate([body.rotation.ravel(), body.translation - hip, box.min_, box.max_]))
        self._boxes = np.array(boxes)
        self._allowed = np.zeros((len(bodies.swing), len(bodies.obstacles)), dtype=np.bool_)
        for swing, obstacle in bodies.pairs:
            self._allowed[swing, obstacle] = True

    def collides(self, angles: ArrayLike) -> bool:
        """Whether any allowed pair touches with the leg at `angles` (3,), in [rad]."""
        return bool(self.touching(angles, first_only=True))

    def touching(self, angles: ArrayLike, first_only: bool = False) -> list[tuple[str, str]]:
        """Names of the pairs of bodies, swing leg's first, that touch at `angles`."""
        q = np.asarray(angles, dtype=np.float64)
        near = _near_pairs(self._swing.leg, self._swing.link, self._swing.spheres, self._boxes, self._allowed, q)
        if not near.any():
            return []
        found = []
        placements = self._swing.placements(q)
        for i, j in np.argwhere(near):
            shape, obstacle = self._swing.bodies[i].shape, self._obstacles[j].shape
            result = coal.CollisionResult()
            if coal.collide(shape, placements[i], obstacle, self._transforms[j], coal.CollisionRequest(), result):
                found.append((self._swing.bodies[i].name, self._obstacles[j].name))
                if first_only:
                    break
        return found


@numba.njit(cache=True)
def _near_pairs(
    leg: NDArray[np.float64],
    link: NDArray[np.int64],
    spheres: NDArray[np.float64],
    boxes: NDArray[np.float64],
    allowed: NDArray[np.bool_],
    angles: NDArray[np.float64],
) -> NDArray[np.bool_]:  # pragma: no cover - compiled
    """(m, n) allowed pairs of which a cover sphere of the swing body reaches the obstacle's bounding box."""
    rotations, origins = np.empty((2, 3, 3)), np.empty((2, 3))
    link_frames(leg, angles[0], angles[1], angles[2], rotations, origins)
    near = np.zeros(allowed.shape, dtype=np.bool_)
    point = np.empty(3)
    for row in range(len(spheres)):
        body = int(spheres[row, 0])
        part = link[body]
        for i in range(3):
            point[i] = origins[part, i]
            for k in range(3):
                point[i] += rotations[part, i, k] * spheres[row, 1 + k]
        square = spheres[row, 4] ** 2
        for obstacle in range(len(boxes)):
            if near[body, obstacle] or not allowed[body, obstacle]:
                continue
            box = boxes[obstacle]
            distance = 0.0
            for k in range(3):
                along = 0.0
                for i in range(3):
                    along += box[3 * i + k] * (point[i] - box[9 + i])
                outside = max(box[12 + k] - along, along - box[15 + k], 0.0)
                distance += outside * outside
            near[body, obstacle] = distance <= square
    return near


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
        """Ask coal at coarse nodes, then at fine nodes near where coarse ones differ; some 400,000 questions."""
        exact = ExactSelfCollision(robot, leg)
        limits = robot.kinematics[leg].limits
        coarse_boxes = np.ceil((limits[:, 1] - limits[:, 0]) / (2 * NODE_STEP)).astype(int)
        axes = [np.linspace(low, high, 2 * n + 1) for (low, high), n in zip(limits, coarse_boxes, strict=True)]
        nodes = np.zeros(2 * coarse_boxes + 1, dtype=np.bool_)

        def ask(which: NDArray[np.bool_], what: str) -> None:
            indices = np.argwhere(which)
            for a, b, c in tqdm(indices, desc=f"{leg} self-collision, {what}", leave=False, disable=None):
                nodes[a, b, c] = exact.collides((axes[0][a], axes[1][b], axes[2][c]))

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


@numba.njit(cache=True)
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
