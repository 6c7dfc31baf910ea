"""One walk as a job of its own: what decides it, and the name that its result is kept under."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from footsel.errors import UnknownNameError
from footsel.runtime.model_folder import SUMS_FILE, find_model_folder
from footsel.selectors import SELECTORS
from footsel.walking.course import WalkCourse
from footsel.walking.courses import WALK_COURSES, make_walk_course
from footsel.walking.maps import MAPS

#: Selectors whose answers depend on the model.
NETWORKS = ("cnn", "cnn+verify")


@dataclass(frozen=True)
class WalkJob:
    """All that decides a walk, but for the software.

    terrain: a name in WALK_COURSES or a map file's path. selector: a name in SELECTORS. map: a name in MAPS.
    model: the network's folder, None for the robot's released one. map_options: how a map file is read, as of
    terrain.formats.load. time_limit_s: of simulated time, None for what `walk` grants a course.
    watch_limbs: whether the planner keeps limbs clear of the ground, whoever chooses the footholds.

    Raises UnknownNameError for a selector or a map that does not exist.
    """

    terrain: str
    selector: str
    seed: int
    map: str = "exact"
    robot: str = "anymal_b"
    model: Path | None = None
    map_options: Mapping[str, Any] = field(default_factory=dict)
    time_limit_s: float | None = None
    watch_limbs: bool = True

    def __post_init__(self) -> None:
        if self.selector not in SELECTORS:
            raise UnknownNameError("selector", self.selector, SELECTORS)
        if self.map not in MAPS:
            raise UnknownNameError("map", self.map, MAPS)

    def course(self) -> WalkCourse:
        """The ground to walk; raises UnknownNameError or MapError if there is none of that name."""
        return make_walk_course(self.terrain, self.seed, **self.map_options)

    def question(self) -> dict[str, Any]:
        """What the walk is asked, as JSON values; a map file and a model count by their content.

        Raises ModelError for a model that is not there, OSError for a map file that cannot be read.
        """
        of_file = self.terrain not in WALK_COURSES
        return {
            "terrain": self.terrain,
            "selector": self.selector,
            "seed": self.seed,
            "map": self.map,
            "robot": self.robot,
            "model": self._model_checksum() if self.selector in NETWORKS else None,
            "map_file": _checksum(Path(self.terrain)) if of_file else None,
            "time_limit_s": self.time_limit_s,
            "watch_limbs": self.watch_limbs,
            "map_options": {name: value for name, value in self.map_options.items() if value} if of_file else {},
        }

    @property
    def file_name(self) -> str:
        """Of its kept result: readable, and different for every terrain, selector and seed."""
        name = Path(self.terrain).stem
        if self.terrain not in WALK_COURSES:
            name += "-" + hashlib.sha256(self.terrain.encode()).hexdigest()[:8]
        return f"{name}_{self.selector}_{self.seed}.json"

    def _model_checksum(self) -> str:
        return _checksum(find_model_folder(self.model or self.robot) / SUMS_FILE)


def _checksum(path: Path) -> str:
    """SHA-256 of a file, or of all files of a folder (a bag of ROS 2)."""
    digest = hashlib.sha256()
    for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
        if not file.is_dir():
            digest.update(file.read_bytes())
    return digest.hexdigest()
