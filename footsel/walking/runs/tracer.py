"""The observer that draws up a walk's trace."""

from collections.abc import Iterable

from footsel.walking.observer import Moment, WalkObserver
from footsel.walking.runs.trace import Point, Trace

#: Between two points of the base's path. [s]
_PERIOD = 0.5


class Tracer(WalkObserver):
    """Fills a trace."""

    def __init__(self) -> None:
        self.trace = Trace()
        self._next = 0.0

    def see(self, moment: Moment) -> None:
        if moment.time >= self._next:
            self.trace.base.append(_point(moment.base[:3, 3]))
            self._next = moment.time + _PERIOD

    def see_choice(self, moment: Moment) -> None:
        choice = moment.choice
        if choice is None:
            return
        if choice.foothold.position is None:
            self.trace.none.append((choice.leg, _point((*choice.nominal[:2], choice.pose.z))))
        else:
            self.trace.footholds.append((choice.leg, _point(choice.foothold.position)))


def _point(position: Iterable[float]) -> Point:
    """To the millimetre."""
    x, y, z = (round(float(value), 3) for value in position)
    return x, y, z
