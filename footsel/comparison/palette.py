"""Colours and marks of all drawings, told apart by lightness too, so that they survive printing and colour blindness.

Categorical colours after Okabe and Ito (2008), "Color Universal Design".
"""

from dataclasses import dataclass

from footsel.footholds import Reason

#: Cost of feasible cells: pale is good, dark is risky.
COST_MAP = "YlOrRd"
#: From the lowest ground to the highest.
TERRAIN_COLOURS = ("#56637a", "#aab2bd", "#ded9cb", "#fffdf6")
DISTANCE_MAP = "PuBu"
DIFFERENCE_MAP = "RdBu_r"
MARGIN_MAP = "YlGn"
ANGLE_MAP = "viridis"

#: Cells that no foot may take, and cells without a height.
INFEASIBLE = "#5b6575"
UNKNOWN = "#e9ebee"

#: Text and lines of drawings: on paper, and where the page behind may be light or dark.
INK = "#1c2430"
NEUTRAL_INK = "#7f8896"

REASON_COLOURS = {
    Reason.FEASIBLE: "#8fd3b6",
    Reason.UNKNOWN: UNKNOWN,
    Reason.KINEMATIC_RANGE: "#5b6575",
    Reason.SELF_COLLISION: "#0072b2",
    Reason.TERRAIN_COLLISION: "#d55e00",
}

#: The same, faint: the background of cells that collide.
FAINT_REASON_COLOURS = {
    Reason.FEASIBLE: "#dff2ea",
    Reason.UNKNOWN: UNKNOWN,
    Reason.KINEMATIC_RANGE: "#b9bec7",
    Reason.SELF_COLLISION: "#b9bec7",
    Reason.TERRAIN_COLLISION: "#b9bec7",
}

#: Two bodies that meet: what the leg hits of the terrain is warm, what it hits of the robot is cold.
TERRAIN_CONTACTS = ("#d55e00", "#f0a830", "#8c2d04", "#f7d35c", "#c0396b", "#f4a582", "#7f3b08", "#fdd0a2")
SELF_CONTACTS = ("#0072b2", "#56b4e9", "#4b2e83", "#00a2a2", "#9e7bd0", "#08306b", "#7fcdbb", "#3b5bdb")
OTHER_CONTACT = "#1c2430"

#: Cells that two judgements call differently: allowed though the oracle forbids it, and the reverse.
FALSE_SAFE = "#d4007f"
FALSE_UNSAFE = "#009e73"


@dataclass(frozen=True)
class Mark:
    """How a selector's pick is drawn. marker: matplotlib's name. size: in points; nested marks show equal picks."""

    marker: str
    size: float
    colour: str


MARKS = {
    "oracle": Mark("o", 15.0, "#ffd21f"),
    "cnn": Mark("o", 9.5, "#00d5ff"),
    "cnn:int8": Mark("d", 8.0, "#00a6bf"),
    "cnn+verify": Mark("D", 6.5, "#5cff7a"),
    "terrain_only": Mark("^", 10.0, "#ff9df0"),
    "traversability": Mark("h", 13.0, "#c9a0ff"),
    "kolter": Mark("p", 12.0, "#ffa64d"),
    "krotkov": Mark("v", 11.0, "#8fb8ff"),
    "roennau": Mark("<", 9.0, "#c7e36b"),
    "chen_kumar": Mark(">", 8.5, "#ff8f80"),
    "rebula": Mark("P", 7.5, "#7ff0d4"),
    "barasuol": Mark("X", 7.0, "#e8c39e"),
    "nominal": Mark("s", 5.0, "#ffffff"),
}
NOMINAL_POINT = Mark("+", 9.0, "#ffffff")

#: Legs in drawings of the whole robot.
LEG_COLOURS = {"LF": "#0072b2", "RF": "#d55e00", "LH": "#009e73", "RH": "#a0529e"}
