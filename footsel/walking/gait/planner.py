"""The next step: which leg, which foothold, and where the base is meanwhile."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import BasePose, Foothold
from footsel.footholds.pose import heading_rotation
from footsel.legs import LEGS, is_right
from footsel.robot.robot import Robot
from footsel.selectors import Selector
from footsel.terrain import ElevationMap
from footsel.walking.control.base_pose import LONGEST_LEG, PoseAnswer, PoseProblem, optimise_base_pose
from footsel.walking.control.limb_clearance import LimbClearance
from footsel.walking.gait.line import Line
from footsel.walking.observer import Choice

Array = NDArray[np.float64]

#: In which order legs swing: after a hind leg the fore leg of its side, so that the base sways twice a cycle.
ORDER = ("LH", "LF", "RH", "RF")
#: Where the feet of a level base belong: ahead of and beside its middle, below it. [m]
STANCE_LENGTH, STANCE_WIDTH, HEIGHT = 0.36, 0.245, 0.45
#: From one foothold of a leg to the next. [m]
STRIDE = 0.28
#: Tried in turn until a selector finds a foothold that gains enough: share of the stride, change of the base's height
#: [m]. The later ones are for a leg that has no foothold at all.
VARIANTS = ((1.0, 0.0), (1.25, 0.0), (1.0, -0.06), (0.6, 0.0), (0.6, -0.06), (0.25, -0.06), (1.5, -0.06))
LAST_FOR_GAIN = 2
#: How far along the line a foot has to get for its swing to be worth it: at its turn, and if no leg gets that far. [m]
ENOUGH_GAIN, LEAST_GAIN = 0.08, 0.015
#: The pose at touchdown depends on the foothold, and the foothold on the pose: how often the selector is asked again at
#: the pose for its own choice, and from which difference on. [m], [rad]
ASK_AGAIN, OTHER_PLACE, OTHER_TILT = 2, 0.015, 0.03
#: Footholds are expected within this distance of N_i, and of the feet's mean height. [m]
NEAR, LEVELS = 0.12, 0.25
_AROUND = np.stack(np.meshgrid(*[np.linspace(-NEAR, NEAR, 7)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
#: The base takes this share of the tilt of the plane through the feet.
TILT_SHARE = 0.8
#: How far the base moves while a leg swings. [m]
SWAY = 0.05
#: A pose is good enough for a step if the base is this far inside the support, and legs are too long by no more. [m]
LEAST_MARGIN, MOST_OVERREACH = 0.025, 0.012


@dataclass(frozen=True, eq=False)
class Step:
    """leg: that swings. foothold: (3,) contact point. goal: (3,) the foot's centre there, in W, in [m].
    lift, touchdown: pose of the base when the swing begins and when it ends.
    """

    leg: str
    foothold: Array
    goal: Array
    lift: BasePose
    touchdown: BasePose


@dataclass(frozen=True, eq=False)
class NoStep:
    """Why there is no step."""

    reason: str


class StepPlanner:
    """Plans one step at a time along a line.

    chosen: told every answer of the selector.
    """

    def __init__(self, robot: Robot, selector: Selector, line: Line, chosen: Callable[[Choice], None]) -> None:
        self._selector, self._line, self._chosen = selector, line, chosen
        self._radius = robot.description.foot_radius
        self._hips = np.array([robot.layout.hips[leg] for leg in LEGS])
        self._places = places()
        self._limbs = LimbClearance(robot)
        self._last = ORDER[-1]

    def plan(self, time: float, elevation_map: ElevationMap, feet: Array, base: BasePose, com: Array) -> Step | NoStep:
        """The next step.

        feet: (4, 3) centres of the standing feet, by LEGS, in W, in [m]. base: its pose.
        com: (3,) centre of mass in the base frame, in [m].
        """
        reasons: dict[str, str] = {}
        best: tuple[float, Step] | None = None
        for turn in range(1, 5):
            leg = self._after(self._last, turn)
            for number, (stride, drop) in enumerate(VARIANTS):
                step = self._try(time, elevation_map, feet, base, com, leg, stride, drop)
                if isinstance(step, NoStep):
                    reasons.setdefault(leg, step.reason)
                    continue
                gain = self._gain(feet, step)
                if gain >= ENOUGH_GAIN:
                    self._last = leg
                    return step
                if best is None or gain > best[0]:
                    best = gain, step
                if number >= LAST_FOR_GAIN:
                    break
        if best is not None and best[0] > LEAST_GAIN:
            self._last = best[1].leg
            return best[1]
        leg = self._after(self._last, 1)
        return NoStep(f"no leg gets any further; {leg}: {reasons.get(leg, 'no foothold ahead')}")

    def _gain(self, feet: Array, step: Step) -> float:
        """How far the foot gets along the line, in [m]."""
        ends = self._line.to_line(np.stack([feet[LEGS.index(step.leg), :2], step.goal[:2]]))
        return float(ends[1, 0] - ends[0, 0])

    def _after(self, leg: str, turns: int) -> str:
        return ORDER[(ORDER.index(leg) + turns) % 4]

    def _try(
        self,
        time: float,
        elevation_map: ElevationMap,
        feet: Array,
        base: BasePose,
        com: Array,
        leg: str,
        stride: float,
        drop: float,
    ) -> Step | NoStep:
        index = LEGS.index(leg)
        nominal = self._nominal(feet, index, stride)
        target = np.array([*nominal, self._likely_height(elevation_map, nominal, feet)])
        touchdown, foothold = None, None
        for _ in range(1 + ASK_AGAIN):
            answer = self._pose_at_touchdown(elevation_map, feet, base, com, index, target, drop)
            if problem := _flaw(answer):
                if foothold is None:
                    return NoStep(problem)
                break
            if touchdown is not None and _near(answer.pose, touchdown):
                break
            choice = self._ask(time, elevation_map, leg, answer.pose, nominal)
            if choice.position is None:
                if foothold is None:
                    return NoStep(choice.reason or "no foothold")
                break
            touchdown, foothold = answer.pose, np.array(choice.position)
            target = foothold + np.array([0.0, 0.0, self._radius])
        assert touchdown is not None and foothold is not None
        if not self._reaches(touchdown, index, target):
            return NoStep("the foothold is beyond the leg's reach")
        lift = self._pose_at_lift(elevation_map, feet, base, com, index, touchdown)
        if problem := _flaw(lift):
            return NoStep(problem)
        return Step(leg, foothold, target, lift.pose, touchdown)

    def _nominal(self, feet: Array, index: int, stride: float) -> Array:
        """(2,) N_i: half a stride and an eighth ahead of the leg's place about the middle of all feet, on the line."""
        middle = self._line.to_line(feet[:, :2])[:, 0].mean()
        along = middle + self._places[index, 0] + 0.625 * stride * STRIDE
        return self._line.to_world(np.array([along, self._places[index, 1]]))

    def _likely_height(self, elevation_map: ElevationMap, nominal: Array, feet: Array) -> float:
        """Of the foot's centre on the foothold to come: a foothold near N_i may be far above or below N_i itself."""
        middle = float(feet[:, 2].mean()) - self._radius
        heights = elevation_map.sample(nominal + _AROUND).astype(np.float64)
        heights = heights[np.abs(np.nan_to_num(heights, nan=np.inf) - middle) < LEVELS]
        return (float(np.median(heights)) if heights.size else middle) + self._radius

    def _ask(self, time: float, elevation_map: ElevationMap, leg: str, pose: BasePose, nominal: Array) -> Foothold:
        foothold = self._selector.select(elevation_map, pose, legs=(leg,), nominal={leg: nominal})[leg]
        x, y = nominal.tolist()
        self._chosen(Choice(time, leg, pose, elevation_map, (x, y), foothold))
        return foothold

    def _pose_at_touchdown(
        self,
        elevation_map: ElevationMap,
        feet: Array,
        base: BasePose,
        com: Array,
        index: int,
        target: Array,
        drop: float,
    ) -> PoseAnswer:
        """Over the standing feet, in reach of the target and, if it can be, over the next step's support as well."""
        landed = feet.copy()
        landed[index] = target
        turn = heading_rotation(self._line.yaw)
        place = (landed - self._stance(drop) @ turn.T).mean(axis=0)
        following = np.delete(landed, LEGS.index(self._after(LEGS[index], 1)), axis=0)
        tilt = TILT_SHARE * plane_tilt(landed @ turn)
        return self._solve(elevation_map, place, tilt, landed, base, com, index, following)

    def _pose_at_lift(
        self, elevation_map: ElevationMap, feet: Array, base: BasePose, com: Array, index: int, touchdown: BasePose
    ) -> PoseAnswer:
        """On the way to the pose at touchdown, as far back as the swing has time to go from."""
        back = base.position - touchdown.position
        share = min(1.0, SWAY / max(float(np.linalg.norm(back)), 1e-6))
        place = touchdown.position + share * back
        ahead = np.array([touchdown.roll, touchdown.pitch])
        tilt = ahead + share * (np.array([base.roll, base.pitch]) - ahead)
        return self._solve(elevation_map, place, tilt, feet, touchdown, com, index, None)

    def _solve(
        self,
        elevation_map: ElevationMap,
        place: Array,
        tilt: Array,
        feet: Array,
        guess: BasePose,
        com: Array,
        index: int,
        following: Array | None,
    ) -> PoseAnswer:
        problem = PoseProblem(
            yaw=self._line.yaw,
            place=place,
            tilt=tilt,
            hips=self._hips,
            feet=feet,
            com=com,
            support=counter_clockwise(np.delete(feet, index, axis=0)[:, :2]),
            next_support=None if following is None else counter_clockwise(following[:, :2]),
            limbs=lambda pose: self._limbs.at(elevation_map, pose, feet),
        )
        return optimise_base_pose(problem, guess)

    def _stance(self, drop: float) -> Array:
        """(4, 3) places of the foot centres in the base frame."""
        return np.column_stack([self._places, np.full(4, -(HEIGHT + drop - self._radius))])

    def _reaches(self, pose: BasePose, index: int, goal: Array) -> bool:
        hip = pose.position + pose.rotation() @ self._hips[index]
        return bool(np.linalg.norm(hip - goal) <= LONGEST_LEG + MOST_OVERREACH)


def _near(pose: BasePose, other: BasePose) -> bool:
    """Whether a selector would hardly answer otherwise at one pose than at the other."""
    moved = np.abs(pose.position - other.position).max()
    return bool(moved < OTHER_PLACE and max(abs(pose.roll - other.roll), abs(pose.pitch - other.pitch)) < OTHER_TILT)


def places() -> Array:
    """(4, 2) where the feet belong about the base's middle, by LEGS, in [m]."""
    signs = np.array([[1.0 if leg[1] == "F" else -1.0, -1.0 if is_right(leg) else 1.0] for leg in LEGS])
    return signs * [STANCE_LENGTH, STANCE_WIDTH]


def _flaw(answer: PoseAnswer) -> str:
    """What is wrong with a pose, or ""."""
    if answer.margin < LEAST_MARGIN:
        return f"no stable pose of the base (centre of mass {100 * answer.margin:.1f} cm inside the support)"
    if answer.overreach > MOST_OVERREACH:
        return f"no pose of the base within reach ({100 * answer.overreach:.1f} cm too far)"
    return ""


def plane_tilt(feet: Array) -> Array:
    """Roll and pitch (2,) of the plane through feet (n, 3) in a frame that has the base's heading, in [rad]."""
    offsets = feet - feet.mean(axis=0)
    slope_x, slope_y = np.linalg.lstsq(offsets[:, :2], offsets[:, 2], rcond=None)[0]
    pitch = -np.arctan(slope_x)
    return np.array([np.arctan(slope_y * np.cos(pitch)), pitch])


def counter_clockwise(corners: Array) -> Array:
    """Corners (k, 2 or 3) in counter-clockwise order around their middle, seen from above."""
    offsets = corners - corners.mean(axis=0)
    return np.asarray(corners[np.argsort(np.arctan2(offsets[:, 1], offsets[:, 0]))])
