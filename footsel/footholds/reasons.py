"""Why a cell is or is not a foothold. The order is the order in which the constraints are checked."""

from enum import IntEnum


class Reason(IntEnum):
    """The first constraint that a cell fails, or FEASIBLE."""

    FEASIBLE = 0
    UNKNOWN = 1
    KINEMATIC_RANGE = 2
    SELF_COLLISION = 3
    TERRAIN_COLLISION = 4


REASON_NAMES = tuple(reason.name for reason in Reason)
