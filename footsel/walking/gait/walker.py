"""The walker: shifts, swings and sets down, tick by tick."""

from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from math import cos, sin

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.selectors import Selector
from footsel.terrain import ElevationMap
from footsel.walking.control.dynamics import Dynamics, Motion
from footsel.walking.control.leg_length import LegLength
from footsel.walking.control.quintic import Quintic
from footsel.walking.control.whole_body import Task, whole_body_effort
from footsel.walking.gait.line import Line
from footsel.walking.gait.look import Lookout
from footsel.walking.gait.narrow_holes import without_narrow_holes
from footsel.walking.gait.planner import NoStep, Step, StepPlanner
from footsel.walking.gait.poses import Situation
from footsel.walking.gait.swing import Swing, plan_swing
from footsel.walking.observer import Choice
from footsel.walking.state import RobotState
from footsel.walking.vectors import length

Array = NDArray[np.float64]

#: Gains of the base, of swinging and of standing feet, as accelerations: [1/s^2], [1/s].
BASE_STIFFNESS = np.array([60.0, 60.0, 80.0, 120.0, 120.0, 80.0])
BASE_DAMPING = np.array([14.0, 14.0, 16.0, 18.0, 18.0, 14.0])
SWING_STIFFNESS, SWING_DAMPING = 500.0, 40.0
STANCE_DAMPING = 10.0
#: Standing still before the first step and after the last. [s]
PAUSE = 0.4
#: Of the base between two swings: at least, and on average beyond that. [s], [m/s]
SHORTEST_SHIFT, SHIFT_SPEED = 0.24, 0.25
#: To look down: how fast the head goes, and how long it stays there. [rad/s], [s]
NOD_SPEED, LOOK_SECONDS = 0.4, 0.4
#: A foot takes up its load, and gives it up, in this time. [s]
LOAD_SECONDS, UNLOAD_SECONDS = 0.12, 0.10
#: The most that a standing foot is asked to carry, and the least. [N]
LARGEST_FORCE, LEAST_FORCE = 450.0, 15.0
#: Of the largest force, when a foot has just landed and before it lifts.
LEAST_SHARE = 0.02
#: A foot has landed once the ground pushes it so hard; a leg that is let down weighs no more than a few newtons. [N]
TOUCHDOWN_FORCE = 2.0
#: No ground is felt until a foot is so far below its foothold: it goes back to where it came from. [m]
MISSING_DEPTH = 0.10
#: Nor does a leg get any longer in search of ground: stretched it is 0.564 m long. [m]
STRETCHED_LEG = 0.555


class Phase(Enum):
    """What the walker is doing."""

    PAUSE = "pause"
    SHIFT = "shift"
    SWING = "swing"
    LOOK = "look"
    STOPPED = "stopped"


class Walker:
    """A crawl along a line.

    phase, step, steps: what it is doing, for which step, and how many it has completed. reason: why it stopped before
    the goal. target: (6,) pose that the base is told to have now. motion: terms of the last tick.
    watch_limbs: as of StepPoses. learns: whether the map may know more after another look.
    """

    def __init__(
        self,
        robot: Robot,
        selector: Selector,
        line: Line,
        elevation_map: Callable[[], ElevationMap],
        chosen: Callable[[Choice], None],
        state: RobotState,
        watch_limbs: bool = True,
        learns: bool = False,
    ) -> None:
        self._dynamics = Dynamics(robot)
        self._lookout = Lookout(robot, line, watch_limbs) if learns else None
        # What is left of a look: how long each move of the base takes, in [s], and where to (6,).
        self._nods: list[tuple[float, Array]] = []
        self._planner = StepPlanner(robot, selector, line, chosen, watch_limbs)
        self._legs = LegLength(robot)
        self._line, self._map, self._radius = line, elevation_map, robot.description.foot_radius
        self.phase = Phase.PAUSE
        self.step: Step | None = None
        self.steps = 0
        self.reason = ""
        self.motion: Motion = self._dynamics.at(state)
        self.target = np.array(_pose_of(state).as_list())
        self._normals = np.tile([0.0, 0.0, 1.0], (4, 1))
        self._until = state.time + PAUSE
        self._command = Quintic.between(
            state.time, PAUSE, (self.target, np.zeros(6), np.zeros(6)), self.target, np.zeros(6)
        )
        self._swing: Swing | None = None
        self._origin = self.motion.feet[0]
        # Since when each foot stands.
        self._standing_since = [-np.inf] * 4

    @property
    def swing_leg(self) -> str | None:
        """The leg in the air."""
        return self.step.leg if self.phase is Phase.SWING and self.step else None

    @property
    def standing(self) -> list[int]:
        """Indices of the standing legs."""
        return [k for k, leg in enumerate(LEGS) if leg != self.swing_leg]

    @property
    def done(self) -> bool:
        """Whether it stands and will not move again."""
        return self.phase is Phase.STOPPED and self._now >= self._until

    def tracking_error(self, state: RobotState) -> float:
        """Distance of the base from where it is told to be, in [m]."""
        return length((state.base[:3, 3] - self.target[:3]).tolist())

    def torques(self, state: RobotState) -> Array:
        """(12,) joint torques at a state, in [Nm]."""
        self._now = state.time
        self.motion = self._dynamics.at(state)
        self._advance(state)
        position, velocity, acceleration = self._command.at(state.time)
        self.target = position
        task = Task(
            base_acceleration=self._base_acceleration(state, position, velocity, acceleration),
            feet_acceleration=self._feet_acceleration(state.time),
            normals=self._normals,
            limits=self._limits(state.time),
        )
        return whole_body_effort(self.motion, state.base[:3, :3], state.linear, state.angular, task).torques

    def _advance(self, state: RobotState) -> None:
        """Go on to the next phase if this one is over."""
        if self.phase is Phase.SWING:
            self._watch_swing(state)
        elif self.phase in (Phase.PAUSE, Phase.SHIFT, Phase.LOOK) and state.time >= self._until:
            if self.phase is Phase.SHIFT:
                self._lift(state)
            elif self.phase is Phase.LOOK and self._nods:
                self._nod(state.time)
            else:
                self._plan(state)

    def _plan(self, state: RobotState) -> None:
        """Begin the shift to the next step, or stop."""
        time, pose = state.time, _pose_of(state)
        if self._line.to_line(state.base[:2, 3])[0] >= self._line.length:
            self._stop(time, "")
            return
        com = (self.motion.com - state.base[:3, 3]) @ state.base[:3, :3]
        if self._look(time, pose, com, stuck=False):
            return
        answer = self._planner.plan(time, self._map(), self.motion.feet, pose, com)
        if isinstance(answer, NoStep):
            if not self._look(time, pose, com, stuck=True):
                self._stop(time, answer.reason)
            return
        self.step = answer
        lift = answer.lift.answer.pose
        distance = float(np.linalg.norm(lift.position - self.target[:3]))
        duration = SHORTEST_SHIFT + distance / SHIFT_SPEED
        self._swing = self._planned_swing(time + duration, self.motion.feet[LEGS.index(answer.leg)], answer.goal)
        speed = answer.lift.speed(answer.touchdown, self._swing)
        self._move_base(time, duration, np.array(lift.as_list()), speed)
        self.phase, self._until = Phase.SHIFT, time + duration

    def _look(self, time: float, pose: BasePose, com: Array, stuck: bool) -> bool:
        """Begin to look down, if that may tell more."""
        if self._lookout is None:
            return False
        down = self._lookout.pose(Situation(self._map(), self.motion.feet, pose, com), stuck)
        if down is None:
            return False
        there, back = np.array(down.as_list()), self.target.copy()
        duration = SHORTEST_SHIFT + max(
            float(np.linalg.norm((there - back)[:3])) / SHIFT_SPEED, float(np.abs(there - back)[3:5].max()) / NOD_SPEED
        )
        self._nods = [(duration, there), (LOOK_SECONDS, there), (duration, back)]
        self.phase = Phase.LOOK
        self._nod(time)
        return True

    def _nod(self, time: float) -> None:
        """The next move of a look."""
        duration, goal = self._nods.pop(0)
        self._move_base(time, duration, goal, np.zeros(6))
        self._until = time + duration

    def _lift(self, state: RobotState) -> None:
        assert self.step is not None
        index = LEGS.index(self.step.leg)
        self._origin = self.motion.feet[index].copy()
        self._swing = self._planned_swing(state.time, self._origin, self.step.goal)
        duration = self.step.lift.pace * (self._swing.end - state.time)
        self._move_base(state.time, duration, np.array(self.step.touchdown.as_list()), np.zeros(6))
        self.phase = Phase.SWING

    def _planned_swing(self, time: float, foot: Array, goal: Array) -> Swing:
        return plan_swing(without_narrow_holes(self._map()), time, foot, goal, self._radius)

    def _watch_swing(self, state: RobotState) -> None:
        """Touchdown, early or late, or no ground at all."""
        assert self.step is not None and self._swing is not None
        index, time = LEGS.index(self.step.leg), state.time
        force = length(state.foot_forces[index])
        sinking = time >= self._swing.down.start and time >= self._swing.along.end - 0.05
        if sinking and force > TOUCHDOWN_FORCE:
            self.steps += 1
            self._standing_since[index] = time
            self._normals[index] = ground_normal(self._map(), self.motion.feet[index], self._radius)
            self.phase = Phase.SHIFT
            self._plan(state)
        elif time > self._swing.end and (
            self._swing.at(time)[0][2] < self.step.goal[2] - MISSING_DEPTH or self._stretched(state, index)
        ):
            back = self._origin - [0, 0, self._radius]
            self.step = replace(self.step, foothold=back, goal=self._origin)
            self._swing = self._planned_swing(time, self.motion.feet[index], self._origin)

    def _stretched(self, state: RobotState, index: int) -> bool:
        """Whether a leg is so long that its knee could turn over."""
        hip = state.base[:3, 3] + state.base[:3, :3] @ self._legs.hips[index]
        return bool(self._legs.between(hip, self.motion.feet[index]) > STRETCHED_LEG)

    def _stop(self, time: float, reason: str) -> None:
        self.phase, self.reason, self._until = Phase.STOPPED, reason, time + PAUSE
        self._move_base(time, PAUSE, self.target, np.zeros(6))

    def _move_base(self, time: float, duration: float, goal: Array, speed: Array) -> None:
        goal = goal.copy()
        goal[5] = self.target[5] + np.angle(np.exp(1j * (goal[5] - self.target[5])))
        self._command = Quintic.between(time, duration, self._command.at(time), goal, speed)

    def _base_acceleration(self, state: RobotState, position: Array, velocity: Array, acceleration: Array) -> Array:
        """(6,) in W: the command's, and what brings the base back to it."""
        wanted = pin.rpy.rpyToMatrix(position[3:])
        turn = _rates_to_angular(position)
        error, speed, ahead = np.empty(6), np.empty(6), np.empty(6)
        error[:3], error[3:] = position[:3] - state.base[:3, 3], pin.log3(wanted @ state.base[:3, :3].T)
        speed[:3], speed[3:] = velocity[:3] - state.linear, turn @ velocity[3:] - state.angular
        ahead[:3], ahead[3:] = acceleration[:3], turn @ acceleration[3:]
        return ahead + BASE_STIFFNESS * error + BASE_DAMPING * speed

    def _feet_acceleration(self, time: float) -> Array:
        """(4, 3) in W."""
        acceleration = -STANCE_DAMPING * self.motion.feet_velocity
        if self.phase is Phase.SWING and self.step and self._swing:
            index = LEGS.index(self.step.leg)
            position, velocity, ahead = self._swing.at(time)
            error = position - self.motion.feet[index]
            rate = velocity - self.motion.feet_velocity[index]
            acceleration[index] = ahead + SWING_STIFFNESS * error + SWING_DAMPING * rate
        return acceleration

    def _limits(self, time: float) -> Array:
        """(4, 2) least and largest normal force: feet that land or are about to lift carry less."""
        limits = np.empty((4, 2))
        for k in range(4):
            share = min(max((time - self._standing_since[k]) / LOAD_SECONDS, LEAST_SHARE), 1.0)
            if self.step and LEGS[k] == self.step.leg:
                if self.phase is Phase.SWING:
                    share = 0.0
                elif self.phase is Phase.SHIFT:
                    share = min(share, max((self._until - time) / UNLOAD_SECONDS, LEAST_SHARE))
            largest = LARGEST_FORCE * share
            limits[k] = min(LEAST_FORCE, largest / 2), largest
        return limits


def ground_normal(elevation_map: ElevationMap, foot: Array, foot_radius: float) -> Array:
    """(3,) normal of the ground that a foot stands on: of the plane through what lies near its contact's height.

    What is more than two centimetres higher or lower belongs to something else than the foot stands on.
    """
    steps = np.linspace(-0.04, 0.04, 5)
    offsets = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    heights = elevation_map.sample(foot[:2] + offsets).astype(np.float64) - (foot[2] - foot_radius)
    near = np.abs(np.nan_to_num(heights, nan=1.0)) < 0.025
    if near.sum() < 6:
        return np.array([0.0, 0.0, 1.0])
    A = np.column_stack([offsets[near], np.ones(near.sum())])
    slope = np.linalg.lstsq(A, heights[near], rcond=None)[0][:2]
    slope *= min(1.0, 0.4 / max(float(np.linalg.norm(slope)), 1e-9))
    normal = np.array([-slope[0], -slope[1], 1.0])
    return np.asarray(normal / np.linalg.norm(normal))


def _pose_of(state: RobotState) -> BasePose:
    roll, pitch, yaw = pin.rpy.matrixToRpy(state.base[:3, :3]).tolist()
    x, y, z = state.base[:3, 3].tolist()
    return BasePose(x, y, z, roll, pitch, yaw)


def _rates_to_angular(pose: Array) -> Array:
    """(3, 3) from the rates of roll, pitch and yaw to the angular velocity in W."""
    _, pitch, yaw = pose[3:].tolist()
    cp, sp, cy, sy = cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    return np.array([[cy * cp, -sy, 0.0], [sy * cp, cy, 0.0], [-sp, 0.0, 1.0]])
