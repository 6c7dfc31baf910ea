"""The next step: which leg, which foothold, and where the base is meanwhile."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import BasePose, Foothold
from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.selectors import Selector
from footsel.terrain import CELLS, ElevationMap
from footsel.walking.gait.line import Line
from footsel.walking.gait.poses import LEAST_BALANCE, Lift, Situation, StepPoses, flaw
from footsel.walking.gait.stance import places
from footsel.walking.gait.swing import plan_swing
from footsel.walking.observer import Choice

Array = NDArray[np.float64]

#: In which order legs swing: after a hind leg the fore leg of its side, so that the base sways twice a cycle.
ORDER = ("LH", "LF", "RH", "RF")
#: From one foothold of a leg to the next. [m]
STRIDE = 0.28
#: Tried in turn until a step gains enough and keeps all limbs clear: share of the stride, how much lower the base is,
#: how much further out N_i is, both in [m].
VARIANTS = ((1.0, 0.0, 0.0), (1.25, 0.0, 0.0), (1.0, 0.06, 0.0))
#: For a leg that has no such step at all, and for all legs if none of them gets any further.
MORE_VARIANTS = (
    *((1.0, -0.05, 0.0), (0.6, 0.0, 0.0), (0.6, -0.05, 0.0), (0.6, 0.06, 0.0), (0.25, 0.06, 0.0), (1.5, 0.06, 0.0)),
    *((0.8, 0.0, 0.08), (0.8, 0.0, -0.08), (0.3, 0.0, 0.08), (0.3, 0.0, -0.08)),
)
#: How far along the line a foot has to get for its swing to be worth it: at its turn, and if no leg gets that far. [m]
ENOUGH_GAIN, LEAST_GAIN = 0.08, 0.015
#: A step is taken at once if no limb lacks more of its distance to the ground on the way, and never if one lacks more
#: than that and what balls are larger than limbs, nor if the swinging leg is folded by more than the first. [m]
SMALL_LACK, LARGEST_LACK = 0.02, 0.05
#: The pose at touchdown depends on the foothold, and the foothold on the pose: how often the selector is asked again at
#: the pose for its own choice, and from which difference on. [m], [rad]
ASK_AGAIN, OTHER_PLACE, OTHER_TILT = 2, 0.015, 0.03
#: A foothold has to serve until its leg lifts again, and to get the robot further. What a metre costs by which the leg
#: would then be too long, a limb too near to the ground, or the gain less than enough. [cost / m]
LACK_WEIGHT = 2000.0
#: A selector is asked for all footholds: before a slope level ground costs so much less that the best all lie behind.
#: Of how many, the best by cost, gain and width, limbs and reach are looked at.
ALL, CANDIDATES = CELLS * CELLS, 60
#: A foot should stand at least so far on its own side of the line, which costs as much, and must stand so far: on feet
#: in one line the robot falls over when a leg swings. [m]
ENOUGH_WIDTH, LEAST_WIDTH = 0.13, 0.05
#: Footholds are expected within this distance of N_i, and of the height of where the leg stands now. [m]
NEAR, LEVELS = 0.12, 0.25
_AROUND = np.stack(np.meshgrid(*[np.linspace(-NEAR, NEAR, 7)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class Step:
    """leg: that swings. foothold: (3,) contact point. goal: (3,) the foot's centre there, in W, in [m].
    lift: where the base is when the swing begins, and how it goes on. touchdown: its pose when the swing ends.
    """

    leg: str
    foothold: Array
    goal: Array
    lift: Lift
    touchdown: BasePose


@dataclass(frozen=True, eq=False)
class NoStep:
    """Why there is no step."""

    reason: str


class StepPlanner:
    """Plans one step at a time along a line.

    chosen: told every answer of the selector. watch_limbs: as of StepPoses.
    """

    def __init__(
        self,
        robot: Robot,
        selector: Selector,
        line: Line,
        chosen: Callable[[Choice], None],
        watch_limbs: bool = True,
    ) -> None:
        self._selector, self._line, self._chosen = selector, line, chosen
        self._radius = robot.description.foot_radius
        self._to_centre = np.array([0.0, 0.0, self._radius])
        self._places = places()
        self._poses = StepPoses(robot, line.yaw, watch_limbs)
        self._last = ORDER[-1]

    def plan(self, time: float, elevation_map: ElevationMap, feet: Array, base: BasePose, com: Array) -> Step | NoStep:
        """The next step.

        feet: (4, 3) centres of the standing feet, by LEGS, in W, in [m]. base: its pose.
        com: (3,) centre of mass in the base frame, in [m].
        """
        now = Situation(elevation_map, feet, base, com)
        reasons: dict[str, str] = {}
        step = self._choose(time, now, reasons, thorough=False) or self._choose(time, now, reasons, thorough=True)
        if step is None:
            leg = _after(self._last, 1)
            return NoStep(f"no leg gets any further; {leg}: {reasons.get(leg, 'no foothold ahead')}")
        self._last = step.leg
        return step

    def _choose(self, time: float, now: Situation, reasons: dict[str, str], thorough: bool) -> Step | None:
        """The first step that is good enough, or the best of those that get the robot further at all.

        thorough: whether legs that have a step, but not one that gains, try all others as well.
        reasons: is told why a leg has no step.
        """
        best: tuple[tuple[bool, float], Step] | None = None
        for turn in range(1, 5):
            leg = _after(self._last, turn)
            can_stand = False
            for variant in (*VARIANTS, *MORE_VARIANTS):
                if can_stand and not thorough and variant in MORE_VARIANTS:
                    break
                step = self._try(time, now, leg, *variant)
                if isinstance(step, NoStep):
                    reasons.setdefault(leg, step.reason)
                    continue
                gain, clear = float(self._gain(now.feet, leg, step.goal)), step.lift.clearance >= -SMALL_LACK
                if gain >= ENOUGH_GAIN and clear:
                    return step
                can_stand |= clear
                rank = clear, gain if clear else step.lift.clearance
                if gain > LEAST_GAIN and (best is None or rank > best[0]):
                    best = rank, step
        return None if best is None else best[1]

    def _gain(self, feet: Array, leg: str, points: Array) -> Array:
        """(...,) how far a leg's foot gets along the line to points (..., 3), in [m]."""
        start = self._line.to_line(feet[LEGS.index(leg), :2])[0]
        return np.asarray(self._line.to_line(points[..., :2])[..., 0] - start)

    def _try(self, time: float, now: Situation, leg: str, stride: float, drop: float, out: float) -> Step | NoStep:
        found = self._foothold(time, now, leg, self._nominal(now.feet, LEGS.index(leg), stride, out), drop)
        if isinstance(found, NoStep):
            return found
        foothold, touchdown = found
        target = foothold + self._to_centre
        if not self._poses.reaches(touchdown, leg, target):
            return NoStep("the foothold is beyond the leg's reach")
        if self._width(leg, target) < LEAST_WIDTH:
            return NoStep("the foothold is too near to the other side's feet")
        swing = plan_swing(now.obstacles, time, now.feet[LEGS.index(leg)], target, self._radius)
        lift = self._poses.at_lift(now, leg, touchdown, swing)
        if problem := _problem(lift):
            return NoStep(problem)
        return Step(leg, foothold, target, lift, touchdown)

    def _foothold(
        self, time: float, now: Situation, leg: str, nominal: Array, drop: float
    ) -> tuple[Array, BasePose] | NoStep:
        """A foothold (3,) and the pose of the base for it, which depend on each other."""
        target = np.array([*nominal, self._likely_height(now, leg, nominal)])
        found: tuple[Array, BasePose] | None = None
        for _ in range(1 + ASK_AGAIN):
            answer = self._poses.at_touchdown(now, leg, target, _after(leg, 1), drop)
            problem = flaw(answer)
            if not problem and not (found and _near(answer.pose, found[1])):
                choice = self._ask(time, now.elevation_map, leg, answer.pose, nominal)
                if choice.position is not None:
                    found = self._lasting(now, leg, answer.pose, choice), answer.pose
                    target = found[0] + self._to_centre
                    continue
                problem = choice.reason or "no foothold"
            return found or NoStep(problem)
        assert found is not None
        return found

    def _nominal(self, feet: Array, index: int, stride: float, out: float = 0.0) -> Array:
        """(2,) N_i: half a stride and an eighth ahead of the leg's place about the middle of all feet, on the line."""
        middle = self._line.to_line(feet[:, :2])[:, 0].mean()
        along = middle + self._places[index, 0] + 0.625 * stride * STRIDE
        across = self._places[index, 1]
        return self._line.to_world(np.array([along, across + np.sign(across) * out]))

    def _likely_height(self, now: Situation, leg: str, nominal: Array) -> float:
        """Of the foot's centre on the foothold to come: a foothold near N_i may be far above or below N_i itself."""
        height = float(now.feet[LEGS.index(leg), 2]) - self._radius
        heights = now.elevation_map.sample(nominal + _AROUND).astype(np.float64)
        heights = heights[np.abs(np.nan_to_num(heights, nan=np.inf) - height) < LEVELS]
        return (float(np.median(heights)) if heights.size else height) + self._radius

    def _ask(self, time: float, elevation_map: ElevationMap, leg: str, pose: BasePose, nominal: Array) -> Foothold:
        answer = self._selector.select(elevation_map, pose, legs=(leg,), nominal={leg: nominal}, top_k=ALL)[leg]
        x, y = nominal.tolist()
        self._chosen(Choice(time, leg, pose, elevation_map, (x, y), answer))
        return answer

    def _lasting(self, now: Situation, leg: str, touchdown: BasePose, choice: Foothold) -> Array:
        """(3,) the best of a choice and its alternatives, if it is to serve until the leg lifts again, to leave room
        for the other side, and to get the robot further.
        """
        assert choice.position is not None and choice.final_cost is not None
        points = np.array([choice.position, *(each.position for each in choice.alternatives)])
        costs = np.array([choice.final_cost, *(each.final_cost for each in choice.alternatives)])
        costs += LACK_WEIGHT * np.maximum(ENOUGH_WIDTH - self._width(leg, points), 0.0)
        costs += LACK_WEIGHT * np.maximum(ENOUGH_GAIN - self._gain(now.feet, leg, points), 0.0)
        best = np.argsort(costs, kind="stable")[:CANDIDATES]
        points, costs = points[best], costs[best]
        costs += LACK_WEIGHT * self._poses.lack_at_end_of_stance(now, leg, touchdown, points + self._to_centre)
        return np.asarray(points[np.argmin(costs)])

    def _width(self, leg: str, points: Array) -> Array:
        """(...,) how far points (..., 3) are on a leg's own side of the line, in [m]."""
        return np.asarray(np.sign(self._places[LEGS.index(leg), 1]) * self._line.to_line(points[..., :2])[..., 1])


def _after(leg: str, turns: int) -> str:
    return ORDER[(ORDER.index(leg) + turns) % 4]


def _problem(lift: Lift) -> str:
    """What is wrong with the way of a step, or ""."""
    if problem := flaw(lift.answer):
        return problem
    if lift.clearance < -LARGEST_LACK:
        return "a thigh or a shank would touch the ground on the way"
    if lift.unfolded < -SMALL_LACK:
        return "the leg would be folded on the way"
    return "" if lift.balance >= LEAST_BALANCE else "the base would have to move so fast that the robot tips over"


def _near(pose: BasePose, other: BasePose) -> bool:
    """Whether a selector would hardly answer otherwise at one pose than at the other."""
    moved = np.abs(pose.position - other.position).max()
    return bool(moved < OTHER_PLACE and max(abs(pose.roll - other.roll), abs(pose.pitch - other.pitch)) < OTHER_TILT)
