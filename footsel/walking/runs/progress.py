"""How far a walk has come, on stderr."""

import sys
from types import TracebackType

import numpy as np
from tqdm import tqdm

from footsel.walking.course import WalkCourse
from footsel.walking.observer import Moment, WalkObserver


class Progress(WalkObserver):
    """A bar of the distance from start to goal."""

    def __init__(self, course: WalkCourse) -> None:
        self._start = np.array(course.start[:2])
        way = np.array(course.goal) - self._start
        self._length = float(np.linalg.norm(way))
        self._ahead = way / self._length
        self._bar = tqdm(
            total=self._length,
            desc=course.name,
            unit="m",
            bar_format="{desc}: {percentage:3.0f}%|{bar}| {n:.2f}/{total:.2f} m [{elapsed}{postfix}]",
            mininterval=0.2 if sys.stderr.isatty() else 15,
        )

    def see(self, moment: Moment) -> None:
        gone = float(np.clip((moment.base[:2, 3] - self._start) @ self._ahead, 0, self._length))
        self._bar.set_postfix_str(f"{moment.time:.0f} s walked", refresh=False)
        self._bar.update(gone - self._bar.n)

    def __enter__(self) -> "Progress":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.close()
