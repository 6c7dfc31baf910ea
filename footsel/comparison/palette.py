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
    "cnn+verify": Mark("D", 6.5, "#5cff7a"),
    "terrain_only": Mark("^", 10.0, "#ff9df0"),
    "nominal": Mark("s", 5.0, "#ffffff"),
}
NOMINAL_POINT = Mark("+", 9.0, "#ffffff")

#: Legs in drawings of the whole robot.
LEG_COLOURS = {"LF": "#0072b2", "RF": "#d55e00", "LH": "#009e73", "RH": "#a0529e"}
