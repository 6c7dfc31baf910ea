"""A foothold: the answer of every selector for one leg."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Alternative:
    """A further candidate, in the order of final cost."""

    position: tuple[float, float, float]
    final_cost: float


@dataclass(frozen=True)
class Foothold:
    """What a selector chose for a leg, or why it chose nothing.

    status: "ok" or "none".
    reason: why there is none; None if there is one.
    position: contact point on the terrain in the world frame, in [m].
    cell: (i, j) in the leg's local map.
    cost: Z_c in [0, 255]. class_: its class, 0..12. final_cost: Z_c + k d_n.
    nominal: N_i in the world frame, in [m]. distance_to_nominal: d_n, in [m].
    confidence: probability that the cell is feasible, as a network sees it; None from selectors that estimate none.
    alternatives: the next best cells.
    """

    status: str
    reason: str | None
    position: tuple[float, float, float] | None
    cell: tuple[int, int] | None
    cost: float | None
    class_: int | None
    final_cost: float | None
    nominal: tuple[float, float, float]
    distance_to_nominal: float | None
    confidence: float | None = None
    alternatives: tuple[Alternative, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """JSON values of `footsel select`."""
        return {
            "status": self.status,
            "reason": self.reason,
            "position": None if self.position is None else list(self.position),
            "cell": None if self.cell is None else list(self.cell),
            "cost": self.cost,
            "class": self.class_,
            "final_cost": self.final_cost,
            "nominal": list(self.nominal),
            "distance_to_nominal": self.distance_to_nominal,
            "confidence": self.confidence,
            "alternatives": [{"position": list(a.position), "final_cost": a.final_cost} for a in self.alternatives],
        }
