"""Ask every selector for all four legs at some base poses of a map, and judge the answers by the oracle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footsel.comparison.contestants import Contestants
from footsel.comparison.tally import Tally
from footsel.footholds import BasePose, CellScores
from footsel.footholds.choice import final_costs
from footsel.footholds.request import prepare
from footsel.legs import LEGS
from footsel.terrain import ElevationMap


@dataclass(frozen=True)
class Outcome:
    """How one leg fared at one base pose; what examples are chosen by.

    known, feasible: shares of the local map's cells. regrets: selector -> final cost of its pick above the best one's,
    inf for a pick that the oracle rejects, None for no pick.
    """

    pose: BasePose
    leg: str
    known: float
    feasible: float
    regrets: Mapping[str, float | None]


@dataclass(frozen=True, eq=False)
class Verdict:
    """legs: leg -> what was counted. times_ms: selector -> wall time of each call for four legs. outcomes: in order."""

    legs: Mapping[str, Tally]
    times_ms: Mapping[str, list[float]]
    outcomes: list[Outcome]

    @classmethod
    def empty(cls, contestants: Contestants) -> "Verdict":
        """Nothing counted yet."""
        names = tuple(contestants.selectors)
        judges_cells = contestants.network is not None
        return cls({leg: Tally(names, judges_cells) for leg in LEGS}, {name: [] for name in names}, [])

    def merge(self, other: "Verdict") -> None:
        """Add the poses of another verdict."""
        for leg, tally in self.legs.items():
            tally.merge(other.legs[leg])
        for name, times in self.times_ms.items():
            times.extend(other.times_ms[name])
        self.outcomes.extend(other.outcomes)


def judge(contestants: Contestants, elevation_map: ElevationMap, poses: Sequence[BasePose]) -> Verdict:
    """All four legs at all `poses`."""
    verdict = Verdict.empty(contestants)
    # The first call compiles and loads; it is not timed.
    for selector in contestants.selectors.values():
        selector.select(elevation_map, poses[0])
    for pose in poses:
        answers = {}
        for name, selector in contestants.selectors.items():
            answers[name], timing = selector.select_timed(elevation_map, pose)
            verdict.times_ms[name].append(timing.total)
        for request in prepare(contestants.layout, elevation_map, pose):
            leg, local_map = request.leg, request.local_map
            label = contestants.oracle.label(local_map, leg, pose.roll, pose.pitch)
            final = final_costs(CellScores(label.cost, label.feasible), local_map, np.array(request.nominal[:2]))
            cells = {name: footholds[leg].cell for name, footholds in answers.items()}
            network = contestants.network
            judged = None if network is None else network.evaluate(local_map.heights, leg, pose.roll, pose.pitch)
            verdict.legs[leg].update(label, final, cells, judged)
            best = float(final.min())
            verdict.outcomes.append(
                Outcome(
                    pose,
                    leg,
                    known=float(local_map.known.mean()),
                    feasible=float(label.feasible.mean()),
                    regrets={
                        name: None
                        if cell is None
                        else (float(final[cell]) - best if np.isfinite(final[cell]) else np.inf)
                        for name, cell in cells.items()
                    },
                )
            )
    return verdict
