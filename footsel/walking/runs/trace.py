"""Where a walk went: kept beside its result, to be drawn."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

Point = tuple[float, float, float]


@dataclass(frozen=True)
class Trace:
    """Of one walk, in W and in [m].

    base: the base's position about twice a second.
    footholds: leg and contact point of every choice, in order; a choice may be made anew before the foot lands.
    none: legs that asked for a foothold and got the answer "none", with the nominal foothold's x, y and the base's z.
    """

    base: list[Point] = field(default_factory=list)
    footholds: list[tuple[str, Point]] = field(default_factory=list)
    none: list[tuple[str, Point]] = field(default_factory=list)

    def to_dict(self) -> dict[str, Any]:
        """As JSON values; `from_dict` is its inverse."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "Trace":
        """From the JSON values of `to_dict`."""
        return cls(
            base=[(x, y, z) for x, y, z in values["base"]],
            footholds=[(leg, (x, y, z)) for leg, (x, y, z) in values["footholds"]],
            none=[(leg, (x, y, z)) for leg, (x, y, z) in values["none"]],
        )
