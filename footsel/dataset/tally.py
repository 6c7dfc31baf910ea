"""Counts of what a dataset holds, per terrain family: local maps, reasons and cost classes of their cells."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.dataset.samples import Samples
from footsel.footholds.cost import CLASSES, cost_to_class
from footsel.footholds.reasons import Reason


@dataclass(frozen=True, eq=False)
class Counts:
    """maps: local maps. reasons: (5,) cells of each Reason. classes: (14,) cells of each cost class."""

    maps: int
    reasons: NDArray[np.int64]
    classes: NDArray[np.int64]

    @classmethod
    def nothing(cls) -> "Counts":
        """Where adding up begins."""
        return cls(0, np.zeros(len(Reason), dtype=np.int64), np.zeros(CLASSES, dtype=np.int64))

    @classmethod
    def of(cls, samples: Samples) -> "Counts":
        """Count samples."""
        reasons = np.bincount(samples.reason.ravel(), minlength=len(Reason))
        costs = np.bincount(samples.cost.ravel(), minlength=256)
        classes = np.zeros(CLASSES, dtype=np.int64)
        np.add.at(classes, cost_to_class(np.arange(256)), costs)
        return cls(len(samples), reasons, classes)

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(self.maps + other.maps, self.reasons + other.reasons, self.classes + other.classes)

    def shares(self) -> dict[str, Any]:
        """As in the manifest: samples; unknown_share of all cells; reason_shares of the known cells, which add up to 1;
        class_shares of all cells, an unknown one being of the last class as an infeasible one is.
        """
        cells = max(int(self.reasons.sum()), 1)
        unknown = int(self.reasons[Reason.UNKNOWN])
        known = max(cells - unknown, 1)
        return {
            "samples": self.maps,
            "unknown_share": unknown / cells,
            "reason_shares": {r.name: int(self.reasons[r]) / known for r in Reason if r is not Reason.UNKNOWN},
            "class_shares": (self.classes / cells).tolist(),
        }


#: Counts per terrain family.
Tally = Mapping[str, Counts]


def tally_of(samples: Samples) -> Tally:
    """Count samples per family."""
    return {family: Counts.of(samples.take(samples.family == family)) for family in np.unique(samples.family).tolist()}


def add_tallies(tallies: Iterable[Tally]) -> Tally:
    """Their sum, families in alphabetical order."""
    total: defaultdict[str, Counts] = defaultdict(Counts.nothing)
    for tally in tallies:
        for family, counts in tally.items():
            total[family] += counts
    return dict(sorted(total.items()))


def tally_shares(tally: Tally) -> dict[str, Any]:
    """As in the manifest: shares of all families together, and of each below `families`."""
    together = sum(tally.values(), start=Counts.nothing())
    return {**together.shares(), "families": {family: counts.shares() for family, counts in tally.items()}}
