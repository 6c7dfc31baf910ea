"""Poses of the base for a step: when the leg lifts, when it lands, and on the way."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import BasePose
from footsel.footholds.pose import heading_rotation
from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.terrain import ElevationMap
from footsel.walking.control.base_pose import LONGEST_LEG, PoseAnswer, PoseProblem, optimise_base_pose
from footsel.walking.control.limb_clearance import LimbClearance
from footsel.walking.gait.stance import HEIGHT, counter_clockwise, places, plane_tilt

Array = NDArray[np.float64]

#: The base takes this share of the tilt of the plane through the feet.
TILT_SHARE = 0.8
#: How far the base moves while a leg swings. [m]
SWAY = 0.05
#: How far the base gets along the line while a foot stands, from its landing until it lifts. [m]
STANCE_ADVANCE = 0.22
#: A pose is good enough for a step if the base is this far inside the support, and legs are too long by no more. [m]
LEAST_MARGIN, MOST_OVERREACH = 0.025, 0.012


@dataclass(frozen=True, eq=False)
class Situation:
    """What a step starts from.

    elevation_map: as known now. feet: (4, 3) centres of the standing feet, by LEGS, in W, in [m]. base: its pose.
    com: (3,) centre of mass in the base frame, in [m].
    """

    elevation_map: ElevationMap
    feet: Array
    base: BasePose
    com: Array


class StepPoses:
    """Finds poses of the base that walks with heading `yaw`, in [rad]."""

    def __init__(self, robot: Robot, yaw: float) -> None:
        self._yaw, self._turn = yaw, heading_rotation(yaw)
        self._hips = np.array([robot.layout.hips[leg] for leg in LEGS])
        self._stance = np.column_stack([places(), np.full(4, robot.description.foot_radius - HEIGHT)])
        self._limbs = LimbClearance(robot)

    def at_touchdown(self, now: Situation, leg: str, target: Array, next_leg: str, drop: float) -> PoseAnswer:
        """When the foot of `leg` lands with its centre at target (3,): over the standing feet, in reach of the target
        and, if it can be, over the support of the leg that swings next as well.

        drop: by how much the base should be lower than usual, in [m].
        """
        landed = _landed(now.feet, leg, target)
        place = (landed - self._stance @ self._turn.T).mean(axis=0) - [0.0, 0.0, drop]
        tilt = TILT_SHARE * plane_tilt(landed @ self._turn)
        following = counter_clockwise(np.delete(landed, LEGS.index(next_leg), axis=0)[:, :2])
        return self._solve(now, place, tilt, landed, now.base, leg, following)

    def at_lift(self, now: Situation, leg: str, touchdown: BasePose) -> PoseAnswer:
        """On the way to the pose at touchdown, as far back as the swing has time to go from."""
        back = now.base.position - touchdown.position
        share = min(1.0, SWAY / max(float(np.linalg.norm(back)), 1e-6))
        ahead = np.array([touchdown.roll, touchdown.pitch])
        tilt = ahead + share * (np.array([now.base.roll, now.base.pitch]) - ahead)
        return self._solve(now, touchdown.position + share * back, tilt, now.feet, touchdown, leg, None)

    def clearance(self, now: Situation, leg: str, lift: BasePose, touchdown: BasePose, target: Array) -> float:
        """Of the limb nearest to the ground, as in Clearance, half way to `lift`, there, half way on and at the end."""
        map_, landed = now.elevation_map, _landed(now.feet, leg, target)
        on_the_way = self._limbs.at(map_, _half_way(lift, touchdown), now.feet).least
        return min(
            self._limbs.at(map_, _half_way(now.base, lift), now.feet).worst,
            self._limbs.at(map_, lift, now.feet).worst,
            float(np.delete(on_the_way, LEGS.index(leg), axis=0).min()),
            self._limbs.at(map_, touchdown, landed).worst,
        )

    def lack_at_end_of_stance(self, now: Situation, leg: str, touchdown: BasePose, targets: Array) -> Array:
        """(n,) by how much the leg would be too long and a limb too near to the ground just before it lifts again, in
        [m], if its foot's centre were at each of targets (n, 3) and the base went on as the feet's plane rises.
        """
        landed = _landed(now.feet, leg, targets[0])
        rise = -np.tan(plane_tilt(landed @ self._turn)[1])
        way = self._turn @ [STANCE_ADVANCE, 0.0, STANCE_ADVANCE * rise]
        x, y, z = (touchdown.position + way).tolist()
        later = BasePose(x, y, z, touchdown.roll, touchdown.pitch, touchdown.yaw)
        clear = self._limbs.of_foot(now.elevation_map, later, leg, targets)
        lengths = np.linalg.norm(self._hip(later, leg) - targets, axis=1)
        return np.maximum(-clear, 0.0) + np.maximum(lengths - LONGEST_LEG, 0.0)

    def reaches(self, pose: BasePose, leg: str, target: Array) -> bool:
        """Whether a leg is long enough for its foot's centre to be at target (3,)."""
        return bool(np.linalg.norm(self._hip(pose, leg) - target) <= LONGEST_LEG + MOST_OVERREACH)

    def _hip(self, pose: BasePose, leg: str) -> Array:
        return np.asarray(pose.position + pose.rotation() @ self._hips[LEGS.index(leg)])

    def _solve(
        self, now: Situation, place: Array, tilt: Array, feet: Array, guess: BasePose, leg: str, following: Array | None
    ) -> PoseAnswer:
        problem = PoseProblem(
            yaw=self._yaw,
            place=place,
            tilt=tilt,
            hips=self._hips,
            feet=feet,
            com=now.com,
            support=counter_clockwise(np.delete(feet, LEGS.index(leg), axis=0)[:, :2]),
            next_support=following,
            limbs=lambda pose: self._limbs.at(now.elevation_map, pose, feet),
        )
        return optimise_base_pose(problem, guess)


def flaw(answer: PoseAnswer) -> str:
    """What is wrong with a pose, or ""."""
    if answer.margin < LEAST_MARGIN:
        return f"no stable pose of the base (centre of mass {100 * answer.margin:.1f} cm inside the support)"
    if answer.overreach > MOST_OVERREACH:
        return f"no pose of the base within reach ({100 * answer.overreach:.1f} cm too far)"
    return ""


def _landed(feet: Array, leg: str, target: Array) -> Array:
    landed = feet.copy()
    landed[LEGS.index(leg)] = target
    return landed


def _half_way(first: BasePose, last: BasePose) -> BasePose:
    turn = np.angle(np.exp(1j * (last.yaw - first.yaw)))
    middle = (np.array(first.as_list()) + np.array(last.as_list())) / 2
    x, y, z, roll, pitch, _ = middle.tolist()
    return BasePose(x, y, z, roll, pitch, float(first.yaw + turn / 2))
