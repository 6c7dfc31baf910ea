"""Poses of the base for a step: when the leg lifts, when it lands, and on the way."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import BasePose
from footsel.footholds.pose import heading_rotation
from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.terrain import ElevationMap
from footsel.walking.control.base_pose import (
    FOLDED_LEG,
    LONGEST_LEG,
    PoseAnswer,
    PoseProblem,
    inward_edges,
    optimise_base_pose,
)
from footsel.walking.control.leg_length import LegLength
from footsel.walking.control.limb_clearance import Clearance, LimbClearance
from footsel.walking.control.quintic import Quintic
from footsel.walking.gait.narrow_holes import without_narrow_holes
from footsel.walking.gait.stance import HEIGHT, counter_clockwise, places, plane_tilt
from footsel.walking.gait.swing import Swing

Array = NDArray[np.float64]

#: The base takes this share of the tilt of the plane through the feet.
TILT_SHARE = 0.8
#: The base is so much lower while the head is down: its hind legs are not long enough else. [m]
CROUCH = 0.06
#: How far the base moves while a leg swings. [m]
SWAY = 0.05
#: How far the base gets along the line while a foot stands, from its landing until it lifts. [m]
STANCE_ADVANCE = 0.22
#: How often limbs are looked at during a swing.
SWING_SAMPLES = 20
#: In which share of the swing the base moves; the quicker where a knee would come too near else.
PACES = (1.0, 0.6)
#: A pose is good enough for a step if the base is this far inside the support, and legs are too long by no more. [m]
LEAST_MARGIN, MOST_OVERREACH = 0.025, 0.012
#: While the base hurries, the zero-moment point stays so far inside the support: a foot that should stand lifts off
#: else, and the robot falls. [m], [m/s^2]
LEAST_BALANCE, GRAVITY = 0.005, 9.81


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

    @property
    def obstacles(self) -> ElevationMap:
        """What limbs and the swinging foot keep clear of."""
        return without_narrow_holes(self.elevation_map)


@dataclass(frozen=True)
class Lift:
    """answer: the pose of the base when a leg lifts. pace: in which share of the swing the base goes on from there to
    its pose at touchdown. clearance: of the limb nearest to the ground until the leg lands, as in Clearance, or of
    the swinging leg from being folded, in [m]. unfolded: the latter alone. balance: how far inside the support the
    zero-moment point stays, in [m].
    """

    answer: PoseAnswer
    pace: float
    clearance: float
    unfolded: float
    balance: float

    def motion_to(self, touchdown: BasePose, swing: Swing) -> Quintic:
        """Of the base (6,) during the swing, if it passes the pose at lift at its speed."""
        duration = self.pace * (swing.end - swing.start)
        start, end = np.array(self.answer.pose.as_list()), np.array(touchdown.as_list())
        return Quintic.between(
            swing.start, duration, (start, self.speed(touchdown, swing), np.zeros(6)), end, np.zeros(6)
        )

    def speed(self, touchdown: BasePose, swing: Swing) -> Array:
        """(6,) of the base when the leg lifts: along the ground alone, as one that is to rise would dip before."""
        speed = np.zeros(6)
        speed[:2] = (touchdown.position - self.answer.pose.position)[:2] / (swing.end - swing.start)
        return speed


class StepPoses:
    """Finds poses of the base that walks with heading `yaw`, in [rad].

    watch_limbs: whether thighs and shanks are held against the map, or left to the choice of footholds.
    """

    def __init__(self, robot: Robot, yaw: float, watch_limbs: bool = True) -> None:
        self._yaw, self._turn = yaw, heading_rotation(yaw)
        self._legs = LegLength(robot)
        self._stance = np.column_stack([places(), np.full(4, robot.description.foot_radius - HEIGHT)])
        self._limbs = LimbClearance(robot, watch_limbs)

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

    def at_lift(self, now: Situation, leg: str, touchdown: BasePose, swing: Swing) -> Lift:
        """On the way to the pose at touchdown, as far back as the swing has time to go from.

        Where a knee would come too near in the swing, poses that regard it and a quicker base are tried as well.
        """
        back = now.base.position - touchdown.position
        share = min(1.0, SWAY / max(float(np.linalg.norm(back)), 1e-6))
        ahead = np.array([touchdown.roll, touchdown.pitch])
        tilt = ahead + share * (np.array([now.base.roll, now.base.pitch]) - ahead)
        place = touchdown.position + share * back
        answer = self._solve(now, place, tilt, now.feet, touchdown, leg)
        best, narrowest = self._judge(now, leg, answer, touchdown, swing, PACES[0])
        if best.clearance < 0 or best.balance < LEAST_BALANCE:
            others = _landed(now.feet, leg, narrowest)
            other = self._solve(now, place, tilt, now.feet, answer.pose, leg, others=others)
            answers = [answer] if flaw(other) else [answer, other]
            tried = [self._judge(now, leg, each, touchdown, swing, pace)[0] for each in answers for pace in PACES]
            best = max(tried, key=lambda lift: (min(lift.balance, LEAST_BALANCE), lift.clearance))
        return best

    def _judge(
        self, now: Situation, leg: str, answer: PoseAnswer, touchdown: BasePose, swing: Swing, pace: float
    ) -> tuple[Lift, Array]:
        """How a pose at lift serves, and where the swinging foot (3,) is when a limb comes nearest to the ground."""
        map_ = now.obstacles
        lift = Lift(answer, pace, np.inf, np.inf, np.inf)
        shift = [self._limbs.worst(map_, _between(now.base, answer.pose, share), now.feet) for share in (0.5, 1.0)]
        motion = lift.motion_to(touchdown, swing)
        times = np.linspace(swing.start, swing.end, SWING_SAMPLES).tolist()
        feet = [swing.at(time)[0] for time in times]
        states = [motion.at(time) for time in times]
        poses = [BasePose(*state[0].tolist()) for state in states]
        ways = list(zip(poses, feet, strict=True))
        limbs = np.array([self._limbs.worst(map_, pose, _landed(now.feet, leg, foot)) for pose, foot in ways])
        unfolded = np.array([self._depth(pose, leg, foot) - FOLDED_LEG for pose, foot in ways])
        clear = np.minimum(limbs, unfolded)
        balance = _balance(now, leg, poses, np.array([state[2][:2] for state in states]))
        worst = min(*shift, float(clear.min()))
        lift = replace(lift, clearance=worst, unfolded=float(unfolded.min()), balance=balance)
        return lift, feet[int(np.argmin(clear))]

    def head_down(self, now: Situation, pitch: float, way: float) -> PoseAnswer:
        """On all four feet, with the head as low as it gets up to a pitch, in [rad], and so far ahead, in [m]."""
        place = now.base.position + self._turn @ [way, 0.0, -CROUCH]
        tilt = np.array([TILT_SHARE * plane_tilt(now.feet @ self._turn)[0], pitch])
        return self._solve(now, place, tilt, now.feet, now.base)

    def lack_at_end_of_stance(self, now: Situation, leg: str, touchdown: BasePose, targets: Array) -> Array:
        """(n,) by how much the leg would be too long and a limb too near to the ground just before it lifts again, in
        [m], if its foot's centre were at each of targets (n, 3) and the base went on as the feet's plane rises.
        """
        landed = _landed(now.feet, leg, targets[0])
        rise = -np.tan(plane_tilt(landed @ self._turn)[1])
        way = self._turn @ [STANCE_ADVANCE, 0.0, STANCE_ADVANCE * rise]
        x, y, z = (touchdown.position + way).tolist()
        later = BasePose(x, y, z, touchdown.roll, touchdown.pitch, touchdown.yaw)
        clear = self._limbs.of_foot(now.obstacles, later, leg, targets)
        lengths = self._length(later, leg, targets)
        return np.asarray(np.maximum(-clear, 0.0) + np.maximum(lengths - LONGEST_LEG, 0.0))

    def reaches(self, pose: BasePose, leg: str, target: Array) -> bool:
        """Whether a leg is long enough for its foot's centre to be at target (3,)."""
        return bool(self._length(pose, leg, target) <= LONGEST_LEG + MOST_OVERREACH)

    def _length(self, pose: BasePose, leg: str, targets: Array) -> Array:
        hip = pose.position + pose.rotation() @ self._legs.hips[LEGS.index(leg)]
        return self._legs.between(hip, targets)

    def _depth(self, pose: BasePose, leg: str, foot: Array) -> float:
        rotation = pose.rotation()
        return self._legs.depth(rotation, pose.position + rotation @ self._legs.hips[LEGS.index(leg)], foot)

    def _solve(
        self,
        now: Situation,
        place: Array,
        tilt: Array,
        feet: Array,
        guess: BasePose,
        leg: str | None = None,
        following: Array | None = None,
        others: Array | None = None,
    ) -> PoseAnswer:
        """leg: that does not stand, if any.

        others: (4, 3) places of the feet at which limbs have to be clear, and legs not folded, as well.
        """

        def limbs(pose: BasePose) -> Clearance:
            clearance = self._limbs.at(now.obstacles, pose, feet)
            return clearance if others is None else clearance.worse(self._limbs.at(now.obstacles, pose, others))

        standing = feet if leg is None else np.delete(feet, LEGS.index(leg), axis=0)
        problem = PoseProblem(
            yaw=self._yaw,
            place=place,
            tilt=tilt,
            legs=self._legs,
            feet=feet,
            com=now.com,
            support=counter_clockwise(standing[:, :2]),
            next_support=following,
            limbs=limbs,
            passing=others,
        )
        return optimise_base_pose(problem, guess)


def flaw(answer: PoseAnswer) -> str:
    """What is wrong with a pose, or ""."""
    if answer.margin < LEAST_MARGIN:
        return f"no stable pose of the base (centre of mass {100 * answer.margin:.1f} cm inside the support)"
    if answer.overreach > MOST_OVERREACH:
        return f"no pose of the base within reach ({100 * answer.overreach:.1f} cm too far)"
    return ""


def _balance(now: Situation, leg: str, poses: list[BasePose], accelerations: Array) -> float:
    """How far inside the support of the other legs the zero-moment point stays, in [m].

    accelerations: (n, 2) of the base in W, at each of the poses, in [m/s^2].
    """
    standing = np.delete(now.feet, LEGS.index(leg), axis=0)
    com = np.array([pose.position + pose.rotation() @ now.com for pose in poses])
    height = com[:, 2:] - standing[:, 2].mean()
    points = com[:, :2] - height / GRAVITY * accelerations
    normals, offsets = inward_edges(counter_clockwise(standing[:, :2]))
    return float((points @ normals.T - offsets).min())


def _landed(feet: Array, leg: str, target: Array) -> Array:
    landed = np.array(feet)
    landed[LEGS.index(leg)] = target
    return landed


def _between(first: BasePose, last: BasePose, share: float) -> BasePose:
    way = np.array(last.as_list()) - np.array(first.as_list())
    way[5] = np.angle(np.exp(1j * way[5]))
    return BasePose(*(np.array(first.as_list()) + share * way).tolist())
