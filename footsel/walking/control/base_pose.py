"""Where the base should be: balanced over the standing feet, in reach of all of them, tilted with the ground, and high
enough that no thigh or shank touches it.

Solved by sequential quadratic programming over x, y, z, roll, pitch at a given yaw. What cannot be met is missed by as
little as possible: bounds are soft, and the answer says by how much they are missed. The idea is that of
Fankhauser, Bjelonic, Bellicoso, Miki and Hutter, "Robust Rough-Terrain Locomotion with a Quadrupedal Robot", ICRA 2018;
the tilt has a cost of its own here, so that a base that leans aside does not roll.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import quadprog
from numpy.typing import NDArray

from footsel.footholds import BasePose
from footsel.walking.control.leg_length import LegLength
from footsel.walking.control.limb_clearance import Clearance

Array = NDArray[np.float64]

#: The centre of mass stays at least this far inside the support polygon. [m]
STABILITY_MARGIN = 0.055
#: Within the leg's plane: 0.564 m is the stretched leg; a folded leg runs into its own base. [m]
LONGEST_LEG, SHORTEST_LEG = 0.535, 0.26
#: A swinging leg may be shorter. But the nearer its foot comes to the hip, or to the axis of abduction, which is ahead
#: of the hip where the head is low, the faster its joints turn and the harder they push the base: at 0.1 m the robot
#: falls. [m]
FOLDED_LEG = 0.13
#: The base tilts no further. [rad]
STEEPEST = 0.4
#: A leg longer than this is told to shorten, if it costs little: the base goes down where feet stand on different
#: levels. [m]
COMFORTABLE_LEG = 0.46
#: What a radian off the best tilt costs beside a metre off the best place, both squared. [m^2 / rad^2]
TILT_WEIGHT = 0.25
#: The same for a metre outside a bound: of support and reach, of the next support, of a comfortable leg, of limbs that
#: stay clear of the ground.
BOUND_WEIGHT, NEXT_WEIGHT, COMFORT_WEIGHT, LIMB_WEIGHT = 2.5e3, 8.0, 2.0, 500.0
#: Slacks of the bounds: of support, next support and reach, and two for each leg, of comfort and of its limbs.
SUPPORT, NEXT, REACH, COMFORT, LIMBS = 0, 1, 2, slice(3, 7), slice(7, 11)
SLACKS = 11
#: Limbs further from the ground than this are no concern of a step. [m]
FAR = 0.15
ITERATIONS = 6
#: Largest change of a position and an angle in one iteration. [m], [rad]
LARGEST_STEP = np.array([0.2, 0.2, 0.2, 0.3, 0.3])


@dataclass(frozen=True, eq=False)
class PoseProblem:
    """What the base has to meet.

    yaw: of the base, in [rad]. place: (3,) where the base would best be, in W, in [m]. tilt: (2,) its best roll and
    pitch, in [rad]. legs: how long they are. feet: (4, 3) foot centres that they have to reach, by LEGS, in W, in [m].
    com: (3,) centre of mass in the base frame, in [m].
    support: (k, 2) corners, counter-clockwise, that the centre of mass lies over.
    next_support: the same of the step to come: met as far as `support` and `reach` allow.
    limbs: how clear of the ground thighs and shanks are at a pose, with the feet where they are.
    passing: (4, 3) where the feet will be as one of them swings by: no leg should be folded then.
    margin: how far inside, in [m].
    """

    yaw: float
    place: Array
    tilt: Array
    legs: LegLength
    feet: Array
    com: Array
    support: Array
    next_support: Array | None = None
    limbs: Callable[[BasePose], Clearance] | None = None
    passing: Array | None = None
    margin: float = STABILITY_MARGIN


@dataclass(frozen=True)
class PoseAnswer:
    """pose: of the base. margin: of the centre of mass inside the support, negative outside. overreach: how much too
    long or too short the worst leg is. clearance: of the limb nearest to the ground beyond the distance that it should
    have, inf if nothing is known of it, all in [m].
    """

    pose: BasePose
    margin: float
    overreach: float
    clearance: float = np.inf


def optimise_base_pose(problem: PoseProblem, guess: BasePose) -> PoseAnswer:
    """The best pose from a first guess."""
    values = np.array([guess.x, guess.y, guess.z, guess.roll, guess.pitch])
    for _ in range(ITERATIONS):
        step = _step(problem, values)
        values = values + step
        if np.abs(step).max() < 1e-4:
            break
    margin, overreach = _quality(problem, values)
    pose = _pose(problem, values)
    return PoseAnswer(pose, margin, overreach, problem.limbs(pose).worst if problem.limbs else np.inf)


def inward_edges(corners: Array) -> tuple[Array, Array]:
    """Normals (k, 2) into a counter-clockwise polygon and offsets (k,): a point p is `normals @ p - offsets` inside."""
    along = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([-along[:, 1], along[:, 0]], axis=-1) / np.linalg.norm(along, axis=1, keepdims=True)
    return normals, np.asarray((normals * corners).sum(axis=1))


def _step(problem: PoseProblem, values: Array) -> Array:
    """(5,) change that solves the problem linearised at `values`."""
    points = np.concatenate([problem.com[None], problem.legs.hips])
    moved, jacobians = _move(problem.yaw, values, points)
    weights = np.empty(SLACKS)
    weights[[SUPPORT, REACH]], weights[NEXT] = BOUND_WEIGHT, NEXT_WEIGHT
    weights[COMFORT], weights[LIMBS] = COMFORT_WEIGHT, LIMB_WEIGHT
    H, c = np.diag(np.concatenate([np.zeros(5), 2 * weights])), np.zeros(5 + SLACKS)
    H[range(3), range(3)] += 2
    c[:3] += 2 * (problem.place - values[:3])
    H[range(3, 5), range(3, 5)] += 2 * TILT_WEIGHT
    c[3:5] += 2 * TILT_WEIGHT * (problem.tilt - values[3:])

    rows, bounds = [], []

    def bound(row: Array, slack: int | None, least: float) -> None:
        rows.append(np.concatenate([row, np.eye(SLACKS)[slack] if slack is not None else np.zeros(SLACKS)]))
        bounds.append(least)

    for slack, corners in ((SUPPORT, problem.support), (NEXT, problem.next_support)):
        if corners is not None:
            for normal, offset in zip(*inward_edges(corners), strict=True):
                bound(normal @ jacobians[0][:2], slack, problem.margin + offset - normal @ moved[0][:2])
    for k, foot in enumerate(problem.feet):
        leg = moved[1 + k] - foot
        length = float(problem.legs.between(moved[1 + k], foot))
        row = leg / length @ jacobians[1 + k]
        bound(-row, REACH, length - LONGEST_LEG)
        bound(-row, COMFORT.start + k, length - COMFORTABLE_LEG)
        bound(row, REACH, SHORTEST_LEG - length)
    if problem.passing is not None:
        for k, foot in enumerate(problem.passing):
            leg = moved[1 + k] - foot
            length = float(problem.legs.between(moved[1 + k], foot))
            bound(leg / length @ jacobians[1 + k], REACH, FOLDED_LEG - length)
    if problem.limbs is not None:
        limbs = problem.limbs(_pose(problem, values))
        for k, limb in np.argwhere(limbs.least < FAR):
            bound(limbs.rates[k, limb], LIMBS.start + k, -limbs.least[k, limb])
    for axis in range(5):
        row = np.eye(5)[axis]
        low, high = -LARGEST_STEP[axis], LARGEST_STEP[axis]
        if axis >= 3:
            low, high = max(low, -STEEPEST - values[axis]), min(high, STEEPEST - values[axis])
        bound(row, None, min(low, 0.0))
        bound(-row, None, -max(high, 0.0))
    for slack in range(SLACKS):
        bound(np.zeros(5), slack, 0.0)
    return np.asarray(quadprog.solve_qp(H, c, np.array(rows).T, np.array(bounds))[0][:5])


def _pose(problem: PoseProblem, values: Array) -> BasePose:
    x, y, z, roll, pitch = values.tolist()
    return BasePose(x, y, z, roll, pitch, problem.yaw)


def _quality(problem: PoseProblem, values: Array) -> tuple[float, float]:
    points = np.concatenate([problem.com[None], problem.legs.hips])
    moved, _ = _move(problem.yaw, values, points)
    normals, offsets = inward_edges(problem.support)
    margin = float((normals @ moved[0][:2] - offsets).min())
    lengths = problem.legs.between(moved[1:], problem.feet)
    return margin, float(np.maximum(lengths - LONGEST_LEG, SHORTEST_LEG - lengths).max())


def _move(yaw: float, values: Array, points: Array) -> tuple[Array, Array]:
    """Points (n, 3) of the base frame in W, and how they move (n, 3, 5) with x, y, z, roll, pitch."""
    cr, sr, cp, sp = np.cos(values[3]), np.sin(values[3]), np.cos(values[4]), np.sin(values[4])
    cy, sy = np.cos(yaw), np.sin(yaw)
    turn = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    pitch = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    roll = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    pitch_rate = np.array([[-sp, 0.0, cp], [0.0, 0.0, 0.0], [-cp, 0.0, -sp]])
    roll_rate = np.array([[0.0, 0.0, 0.0], [0.0, -sr, -cr], [0.0, cr, -sr]])
    jacobians = np.zeros((len(points), 3, 5))
    jacobians[:, :, :3] = np.eye(3)
    jacobians[:, :, 3] = points @ (turn @ pitch @ roll_rate).T
    jacobians[:, :, 4] = points @ (turn @ pitch_rate @ roll).T
    return values[:3] + points @ (turn @ pitch @ roll).T, jacobians
