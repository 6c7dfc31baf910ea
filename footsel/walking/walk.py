"""One walk: a robot, a course, a selector."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.legs import LEGS
from footsel.robot.robot import Robot, load_robot
from footsel.selectors import Selector
from footsel.terrain import ElevationMap
from footsel.walking.course import WalkCourse
from footsel.walking.gait.line import Line
from footsel.walking.gait.stance import counter_clockwise
from footsel.walking.gait.start import standing_start
from footsel.walking.gait.walker import Walker
from footsel.walking.map_source import MapSource
from footsel.walking.metrics import Metrics
from footsel.walking.observer import Choice, Moment, WalkObserver
from footsel.walking.result import WalkResult
from footsel.walking.simulation import TIME_STEP, Simulation
from footsel.walking.state import GroundTruth, StateEstimator

Array = NDArray[np.float64]

#: How often observers see the walk, and how often the map source takes notice of the world. [s]
OBSERVER_PERIOD, MAP_PERIOD = 0.04, 0.1
#: A walk may take as long as a robot needs that is this slow, and some more. [m/s], [s]
SLOWEST, EXTRA_SECONDS = 0.03, 20.0
#: A robot so far tilted, or so far from where it should be, has fallen. [rad], [m]
FALLEN_TILT, FALLEN_DISTANCE = 0.9, 0.2
#: Success needs less distance between the base and where it was told to be. [m]
MOST_TRACKING_ERROR = 0.10
#: The true base may be so far short of the goal that it believes to have reached. [m]
GOAL_TOLERANCE = 0.15
ROBOT = "anymal_b"


def walk(
    course: WalkCourse,
    selector: Selector,
    map_source: MapSource | Callable[[Simulation], MapSource],
    seed: int,
    map_name: str,
    selector_name: str = "",
    observers: Sequence[WalkObserver] = (),
    time_limit_s: float | None = None,
    estimator: StateEstimator | None = None,
    watch_limbs: bool = True,
) -> WalkResult:
    """Let ANYmal B walk over a course.

    map_source: the walker's only knowledge of the terrain, or what makes it once there is a simulation to look at.
    seed: varies how the robot stands at the start. map_name, selector_name: as they stand in the result.
    time_limit_s: of simulated time; by default generous for the course's length.
    estimator: of the state that controller and map source believe in; the truth by default.
    watch_limbs: whether the planner holds thighs and shanks against the map, or leaves them to the selector alone.
    """
    robot = load_robot(ROBOT)
    base, joints = standing_start(robot, course, seed)
    with Simulation(course.ground, robot, base, joints) as simulation:
        source = map_source if isinstance(map_source, MapSource) else map_source(simulation)
        truth = estimator or GroundTruth()
        run = _Walk(course, robot, selector, source, simulation, observers, truth, watch_limbs)
        limit = time_limit_s or run.line.length / SLOWEST + EXTRA_SECONDS
        start = time.perf_counter()
        reason = run.go(limit)
        wall = time.perf_counter() - start
        result = WalkResult(
            terrain=course.name,
            selector=selector_name,
            seed=seed,
            map=map_name,
            success=not reason,
            reason=reason,
            distance_m=float(run.line.to_line(simulation.state().base[:2, 3])[0]),
            duration_s=simulation.time,
            steps=run.walker.steps,
            realtime_factor=simulation.time / wall,
            **run.metrics.figures(),
        )
        for observer in observers:
            observer.see_end(run.moment(), result)
    return result


@dataclass(eq=False)
class _Walk:
    """The loop of one walk and all that takes part in it."""

    course: WalkCourse
    robot: Robot
    selector: Selector
    source: MapSource
    simulation: Simulation
    observers: Sequence[WalkObserver]
    estimator: StateEstimator
    watch_limbs: bool

    def __post_init__(self) -> None:
        self.line = Line.of(self.course)
        self.metrics = Metrics(self.robot.description.foot_radius)
        self._choice: Choice | None = None
        self._state = self.estimator.estimate(self.simulation.state())
        self._notice_world()
        self.walker = Walker(
            self.robot,
            self.selector,
            self.line,
            self._map,
            self._chosen,
            self._state,
            self.watch_limbs,
            self.source.learns,
        )

    def go(self, limit: float) -> str:
        """Walk until the goal, a fall, a stop or the time limit; why it failed, or ""."""
        every_map, every_view = round(MAP_PERIOD / TIME_STEP), round(OBSERVER_PERIOD / TIME_STEP)
        tick = 0
        while not self.walker.done:
            if tick and tick % every_map == 0:
                self._notice_world()
            if tick % every_view == 0:
                for observer in self.observers:
                    observer.see(self.moment())
            torques = self.walker.torques(self._state)
            self.simulation.step(torques)
            self.metrics.notice(self.simulation, self._state, self.walker)
            self._state = self.estimator.estimate(self.simulation.state())
            tick += 1
            if problem := self._fallen():
                return problem
            if self.simulation.time >= limit:
                return f"goal not reached within {limit:.0f} s"
        return self.walker.reason or self._judgement()

    def moment(self) -> Moment:
        """The walk as it is now."""
        walker, radius = self.walker, self.robot.description.foot_radius
        feet = walker.motion.feet - [0.0, 0.0, radius]
        footholds = dict(zip(LEGS, feet, strict=True))
        if walker.step is not None and walker.swing_leg:
            footholds[walker.swing_leg] = walker.step.foothold
        truth = self.simulation.state()
        return Moment(
            time=self.simulation.time,
            base=truth.base,
            joints=truth.joints,
            swing_leg=walker.swing_leg,
            footholds=footholds,
            support_polygon=counter_clockwise(feet[walker.standing]),
            choice=self._choice,
            simulation=self.simulation,
        )

    def _notice_world(self) -> None:
        state = self._state
        self.source.update(state.time, state.base, state.joints)
        self.source.feel(state.base, state.joints, state.foot_forces)

    def _map(self) -> ElevationMap:
        return self.source.elevation_map()

    def _chosen(self, choice: Choice) -> None:
        self._choice = choice
        if self.observers:
            moment = self.moment()
            for observer in self.observers:
                observer.see_choice(moment)

    def _fallen(self) -> str:
        if self._state.base[2, 2] < np.cos(FALLEN_TILT):
            return self._with_contacts("fell: the base turned over")
        if self.walker.tracking_error(self._state) > FALLEN_DISTANCE:
            return self._with_contacts("fell: the base dropped")
        return ""

    def _with_contacts(self, problem: str) -> str:
        touched = self.metrics.touched
        return f"{problem} ({', '.join(touched)} touched the ground)" if touched else problem

    def _judgement(self) -> str:
        """Why a walk that ended at its goal is no success, or ""."""
        left = self.line.length - float(self.line.to_line(self.simulation.state().base[:2, 3])[0])
        if left > GOAL_TOLERANCE:
            return f"stopped before the goal ({left:.2f} m)"
        if self.metrics.touched:
            return f"limbs touched the ground ({', '.join(self.metrics.touched)})"
        if self.metrics.tracking_error >= MOST_TRACKING_ERROR:
            return f"base not where it was told to be ({100 * self.metrics.tracking_error:.0f} cm away)"
        return ""
