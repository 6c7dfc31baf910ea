"""Terrain scorers from the literature that the paper builds on, adapted to a 40x40 local map of 2 cm cells.

Each judges the shape of the ground alone, as `terrain_only` does: no kinematics, no collisions. A scorer's file names
its source, what was taken from it and what was adapted; numbers that the source learned or tuned on its own robot are
replaced by ours, for ANYmal's ball foot of 3.1 cm radius. All windows are fixed in metres.
"""

from footsel.selectors.classic.barasuol import Barasuol
from footsel.selectors.classic.chen_kumar import ChenKumar
from footsel.selectors.classic.kolter import Kolter
from footsel.selectors.classic.krotkov import Krotkov
from footsel.selectors.classic.rebula import Rebula
from footsel.selectors.classic.roennau import Roennau
from footsel.selectors.classic.scorer import Judgement, TerrainScorer
from footsel.selectors.classic.traversability import Traversability

#: By the name that a user types, in the order of the paper's related work.
SCORERS: dict[str, type[TerrainScorer]] = {
    "krotkov": Krotkov,
    "chen_kumar": ChenKumar,
    "barasuol": Barasuol,
    "rebula": Rebula,
    "kolter": Kolter,
    "roennau": Roennau,
    "traversability": Traversability,
}

__all__ = ["SCORERS", "Judgement", "TerrainScorer"]
