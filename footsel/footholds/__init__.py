"""What a foothold is: reasons, costs and classes, the layout of a robot's legs, and how a cell is chosen."""

from footsel.footholds.choice import DISTANCE_WEIGHT, CellScores, choose
from footsel.footholds.foothold import Alternative, Foothold
from footsel.footholds.layout import LegLayout
from footsel.footholds.pose import BasePose
from footsel.footholds.reasons import REASON_NAMES, Reason

__all__ = [
    "DISTANCE_WEIGHT",
    "REASON_NAMES",
    "Alternative",
    "BasePose",
    "CellScores",
    "Foothold",
    "LegLayout",
    "Reason",
    "choose",
]
