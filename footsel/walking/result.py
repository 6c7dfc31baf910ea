"""What came of one walk."""

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class WalkResult:
    """One entry of `runs` in `walks.json`; the names are the contract's.

    map: exact, noisy or camera. success: the goal was reached, nothing but feet and lower shanks touched the
    ground, and the tracking error stayed under 10 cm. reason: why it failed, in a few words; "" for a success.
    distance_m: of the base towards the goal. duration_s: of simulated time. steps: swings completed.
    slip_*: travel of a foot while it stands, per stance. shank_impacts: contacts of a shank above 500 N.
    tracking_error_mm: largest distance of the base from where it was told to be.
    min_stability_margin_m: least distance of the centre of mass inside the support polygon, negative outside.
    hind_shank_contact_s: time during which a hind shank touched the ground, above the lower shank or not.
    realtime_factor: simulated over wall time.
    """

    terrain: str
    selector: str
    seed: int
    map: str
    success: bool
    reason: str
    distance_m: float
    duration_s: float
    steps: int
    slip_mean_mm: float
    slip_max_mm: float
    shank_impacts: int
    tracking_error_mm: float
    min_stability_margin_m: float
    hind_shank_contact_s: float
    realtime_factor: float

    def to_dict(self) -> dict[str, Any]:
        """As in `walks.json`."""
        return asdict(self)
