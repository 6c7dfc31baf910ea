"""The oracle as a selector: exact for every cell."""

from collections import Counter

from footsel.footholds import CellScores, LegLayout, Reason
from footsel.footholds.request import LegRequest
from footsel.oracle import Label, Oracle
from footsel.selectors.base import Selector


class OracleSelector(Selector):
    """The oracle's cost where it finds a foothold."""

    def __init__(self, layout: LegLayout, oracle: Oracle) -> None:
        super().__init__(layout)
        self._oracle = oracle

    def score(self, request: LegRequest) -> CellScores:
        label = self._oracle.label(request.local_map, request.leg, request.pose.roll, request.pose.pitch)
        return CellScores(label.cost, label.feasible, _why_none(label))


def _why_none(label: Label) -> str:
    """How many known cells failed each constraint."""
    counts = Counter(label.reason.ravel().tolist())
    failed = [
        f"{counts[reason]} {reason.name.lower().replace('_', ' ')}"
        for reason in Reason
        if reason not in (Reason.FEASIBLE, Reason.UNKNOWN) and counts[reason]
    ]
    return f"no known cell is feasible: {', '.join(failed)}"
