"""One walk: a robot, a course, a selector."""

from collections.abc import Callable, Sequence

from footsel.selectors import Selector
from footsel.walking.course import WalkCourse
from footsel.walking.map_source import MapSource
from footsel.walking.observer import WalkObserver
from footsel.walking.result import WalkResult
from footsel.walking.simulation.simulation import Simulation
from footsel.walking.state import GroundTruth, StateEstimator

#: How often observers see the walk. [s]
OBSERVER_PERIOD = 0.04
#: How often the map source takes notice of the world. [s]
MAP_PERIOD = 0.1


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
) -> WalkResult:
    """Let ANYmal B walk over a course.

    map_source: the walker's only knowledge of the terrain, or what makes it once there is a simulation to look at.
    seed: varies how the robot stands at the start. map_name, selector_name: as they stand in the result.
    time_limit_s: of simulated time; by default generous for the course's length.
    estimator: of the state that controller and map source believe in; the truth by default.
    """
    del course, selector, map_source, seed, map_name, selector_name, observers, time_limit_s
    _ = estimator or GroundTruth()
    raise NotImplementedError
