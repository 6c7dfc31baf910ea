"""Comparing a label with the reference, and what came of it."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from footsel.footholds import Reason
from footsel.oracle.brute_force import BruteForceOracle
from footsel.oracle.explanation import LegExplainer
from footsel.oracle.labeler import Label, Oracle
from footsel.oracle.verification.places import Place, draw_cells, draw_place

#: Margins are chosen evenly from bins of this size. [m]
MARGIN_BIN = 0.02

#: A source that never gets its number of known cells is left after so many places for each that should have done.
PATIENCE = 20


@dataclass
class Comparison:
    """What was compared and what differed.

    reasons: number of cells by the reference's reason, as in Reason.
    differing: a line for each cell that differs. terrain_cost_error: the largest.
    margins: [fast, reference] of the cells whose margin was compared, in [m].
    heights: least and greatest height of the base over the ground, in [m]; tilt: greatest roll or pitch, in [rad].
    """

    places: int = 0
    reasons: list[int] = field(default_factory=lambda: [0] * len(Reason))
    differing: list[str] = field(default_factory=list)
    terrain_cost_error: float = 0.0
    margins: list[list[float]] = field(default_factory=list)
    heights: list[float] = field(default_factory=lambda: [np.inf, -np.inf])
    tilt: float = 0.0

    @property
    def cells(self) -> int:
        """Number of cells compared."""
        return sum(self.reasons)

    @property
    def known_cells(self) -> int:
        """Number of known cells compared."""
        return self.cells - self.reasons[Reason.UNKNOWN]

    @property
    def margin_errors(self) -> NDArray[np.float64]:
        """(k,) in [m]."""
        pairs = np.array(self.margins).reshape(-1, 2)
        return np.asarray(np.abs(pairs[:, 0] - pairs[:, 1]))

    def enter(self, place: Place) -> None:
        """Note where the base stands."""
        self.places += 1
        self.heights = [min(self.heights[0], place.height), max(self.heights[1], place.height)]
        self.tilt = max(self.tilt, *map(abs, place.tilt))

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values; Comparison(**values) is the inverse."""
        return asdict(self)

    @classmethod
    def sum(cls, parts: Iterable["Comparison"]) -> "Comparison":
        """All parts in one."""
        total = cls()
        for part in parts:
            total.places += part.places
            total.reasons = [a + b for a, b in zip(total.reasons, part.reasons, strict=True)]
            total.differing = total.differing + part.differing
            total.terrain_cost_error = max(total.terrain_cost_error, part.terrain_cost_error)
            total.margins = total.margins + part.margins
            total.heights = [min(total.heights[0], part.heights[0]), max(total.heights[1], part.heights[1])]
            total.tilt = max(total.tilt, part.tilt)
        return total


def compare_cells(
    label: Label, reference: BruteForceOracle, place: Place, cells: NDArray[np.intp], into: Comparison
) -> None:
    """Compare reason and terrain cost of `cells` (k, 2) of a place's label with the reference."""
    for i, j in cells.tolist():
        expected = reference.label_cell(place.local_map, *place.tilt, (i, j), with_margin=False)
        into.reasons[expected.reason] += 1
        found = Reason(int(label.reason[i, j]))
        if found != expected.reason:
            touching = (
                LegExplainer(reference.robot, place.leg).cell(label, place.local_map, *place.tilt, (i, j)).touching
            )
            into.differing.append(
                f"{place} --cell {i} {j}: {_said(found, *touching)}, "
                f"the reference says {_said(expected.reason, *filter(None, [expected.touching]))}"
            )
        elif found != Reason.UNKNOWN:
            # A cost that is no number must not pass.
            error = abs(float(label.terrain_cost[i, j]) - expected.terrain_cost)
            into.terrain_cost_error = max(into.terrain_cost_error, error if error >= 0 else np.inf)


def compare_source(
    source: str,
    leg: str,
    cells: int,
    cells_per_place: int,
    margins: int,
    seed: int = 0,
    oracle: Oracle | None = None,
) -> Comparison:
    """Compare at random places of one leg on a course family, by name, or on a map file, by path.

    cells: known cells in all. margins: how many are compared, evenly over their size as far as the places have them.
    """
    oracle = oracle or Oracle.load()
    reference = BruteForceOracle(oracle.robot, leg)
    rng = np.random.default_rng([seed, crc32(f"{Path(source).name} {leg}".encode())])
    comparison = Comparison()
    feasible: list[tuple[Place, tuple[int, int], float]] = []
    for _ in range(PATIENCE * -(-cells // cells_per_place)):
        place = draw_place(oracle.robot.layout, source, leg, rng)
        comparison.enter(place)
        label = oracle.label(place.local_map, leg, *place.tilt)
        chosen = draw_cells(place.local_map, min(cells_per_place, cells - comparison.known_cells), rng)
        compare_cells(label, reference, place, chosen, comparison)
        feasible += [
            (place, (i, j), float(label.kinematic_margin[i, j])) for i, j in chosen.tolist() if label.feasible[i, j]
        ]
        if comparison.known_cells >= cells:
            break
    for index in evenly_by_size([margin for _, _, margin in feasible], margins, rng):
        place, cell, margin = feasible[index]
        expected = reference.label_cell(place.local_map, *place.tilt, cell)
        comparison.margins.append([margin, expected.margin])
    return comparison


def evenly_by_size(margins: list[float], count: int, rng: np.random.Generator) -> list[int]:
    """Indices of `count` margins, one after another from each bin of sizes that has some left."""
    order = rng.permutation(len(margins))
    bins = np.floor(np.array(margins)[order] / MARGIN_BIN)
    # A margin's turn is the number of those before it in its bin.
    turn = np.zeros(len(margins), dtype=int)
    for value in np.unique(bins):
        turn[bins == value] = np.arange(int((bins == value).sum()))
    return [int(index) for index in order[np.argsort(turn, kind="stable")][:count]]


def _said(reason: Reason, *touching: tuple[str, str]) -> str:
    met = ", ".join(f"{swing} against {other}" for swing, other in touching)
    return f"{reason.name} ({met})" if met else reason.name
