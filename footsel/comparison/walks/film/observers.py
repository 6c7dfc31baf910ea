"""Observers that make a film of a walk, and a still picture of its middle."""

from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footsel.comparison.walks.film.camera import Camera
from footsel.comparison.walks.film.painter import Painter
from footsel.comparison.walks.film.stage import Stage
from footsel.errors import MissingExtraError
from footsel.files import replace_file
from footsel.robot.robot import Robot
from footsel.selectors import Selector
from footsel.walking.course import WalkCourse
from footsel.walking.observer import Moment, WalkObserver

try:
    import av
except ImportError:
    raise MissingExtraError("films of walks", "sim", "av") from None

#: Pictures per second of film, and how much faster than life it runs.
RATE, SPEED = 25, 4
WIDTH, HEIGHT = 960, 400
#: Of x264: higher is smaller and worse. A whole walk stays below 2 MB.
QUALITY = "30"
#: Ground that is seen before the start and behind the goal; what a still shows of the way. [m]
AROUND, STILL_SPAN = 0.9, 2.9


class Film(WalkObserver):
    """Writes an mp4 of the whole course, the camera at rest. The file appears when it is closed without error."""

    def __init__(self, path: Path, course: WalkCourse, robot: Robot, selector: Selector, caption: str = "") -> None:
        start, goal = np.array(course.start[:2]), np.array(course.goal)
        span = float(np.linalg.norm(goal - start)) + 2 * AROUND
        middle = (start + goal) / 2
        focus = [*middle, float(np.nanmedian(course.ground.elevation)) + 0.15]
        camera = Camera.beside(focus, course.start[2], span, WIDTH, HEIGHT)
        self._stage = Stage(course.ground, robot, camera)
        self._painter = Painter(camera, selector, caption or course.name)
        self._trail = _Trail()
        self._path = path
        self._temporary = path.with_name(f".{path.stem}.tmp{path.suffix}")
        self._container = av.open(str(self._temporary), "w")
        self._stream = self._container.add_stream("libx264", rate=RATE, options={"crf": QUALITY, "preset": "slow"})
        self._stream.width, self._stream.height, self._stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        self._next = 0.0

    def see(self, moment: Moment) -> None:
        self._trail.see(moment)
        if moment.time >= self._next:
            self._next += SPEED / RATE
            picture = self._stage.render(moment.base, moment.joints)
            frame = av.VideoFrame.from_ndarray(self._painter.paint(picture, moment, self._trail.points), format="rgb24")
            self._container.mux(self._stream.encode(frame))

    def __enter__(self) -> "Film":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stage.close()
        self._container.mux(self._stream.encode())
        self._container.close()
        if kind is None:
            self._temporary.replace(self._path)
        self._temporary.unlink(missing_ok=True)


class Still(WalkObserver):
    """Writes a PNG of the robot from near, when it is half way, or when the walk ends before."""

    def __init__(self, path: Path, course: WalkCourse, robot: Robot, selector: Selector, caption: str = "") -> None:
        self._path, self._course, self._robot, self._selector = path, course, robot, selector
        self._caption = caption or course.name
        self._trail = _Trail()
        self._drawn = False
        self._start = np.array(course.start[:2])
        self._half_way = (np.array(course.goal) - self._start) / 2

    def see(self, moment: Moment) -> None:
        self._trail.see(moment)
        gone = (moment.base[:2, 3] - self._start) @ self._half_way
        if not self._drawn and gone >= self._half_way @ self._half_way and moment.swing_leg is not None:
            self._draw(moment)

    def see_end(self, moment: Moment, result: object) -> None:  # noqa: ARG002 - what came of it is not drawn
        if not self._drawn:
            self._draw(moment)

    def _draw(self, moment: Moment) -> None:
        self._drawn = True
        focus = moment.base[:3, 3] - [0, 0, 0.25]
        camera = Camera.beside(focus, self._course.start[2], STILL_SPAN, 2 * WIDTH, 2 * HEIGHT)
        stage = Stage(self._course.ground, self._robot, camera)
        try:
            picture = stage.render(moment.base, moment.joints)
        finally:
            stage.close()
        image = Image.fromarray(
            Painter(camera, self._selector, self._caption).paint(picture, moment, self._trail.points)
        )
        replace_file(self._path, image.save)


class _Trail:
    """Where feet have stood."""

    def __init__(self) -> None:
        self.points: list[tuple[str, NDArray[np.float64]]] = []
        self._last: dict[str, NDArray[np.float64]] = {}

    def see(self, moment: Moment) -> None:
        for leg, point in moment.footholds.items():
            before = self._last.get(leg)
            if leg != moment.swing_leg and (before is None or np.linalg.norm(point - before) > 0.02):
                self.points.append((leg, point.copy()))
                self._last[leg] = point.copy()
