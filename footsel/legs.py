"""The four legs: LF RF LH RH, the pairs that share a model, and which leg mirrors which."""

from collections.abc import Iterable

from footsel.errors import UnknownNameError

LEGS = ("LF", "RF", "LH", "RH")
PAIRS = ("front", "hind")

#: One side is trained; the other side is its mirror image about the base's xz plane.
TRAINED_LEG = {"front": "LF", "hind": "LH"}

_MIRROR = {"LF": "RF", "RF": "LF", "LH": "RH", "RH": "LH"}


def check_leg(leg: str) -> str:
    """Return `leg` if it names one of LEGS, else raise UnknownNameError."""
    if leg not in LEGS:
        raise UnknownNameError("leg", leg, LEGS)
    return leg


def check_legs(legs: Iterable[str]) -> tuple[str, ...]:
    """Return `legs` as a tuple of valid names, each once, in the order given."""
    return tuple(dict.fromkeys(check_leg(leg) for leg in legs))


def check_pair(pair: str) -> str:
    """Return `pair` if it names one of PAIRS, else raise UnknownNameError."""
    if pair not in PAIRS:
        raise UnknownNameError("leg pair", pair, PAIRS)
    return pair


def pair_of(leg: str) -> str:
    """'front' for LF and RF, 'hind' for LH and RH."""
    return "front" if check_leg(leg)[1] == "F" else "hind"


def mirror_of(leg: str) -> str:
    """The leg on the other side."""
    return _MIRROR[check_leg(leg)]


def is_right(leg: str) -> bool:
    """Whether the leg is on the right, the side that is evaluated through its mirror image."""
    return check_leg(leg)[0] == "R"
