"""The network that a recipe asks for."""

from footsel.footholds import LegLayout
from footsel.learning.erfnet import ERFNet
from footsel.learning.footnet import FootNet
from footsel.learning.network import FootholdNetwork
from footsel.learning.recipe import Recipe
from footsel.learning.skeleton import LegSkeleton


def build_network(recipe: Recipe, layout: LegLayout, skeleton: LegSkeleton | None = None) -> FootholdNetwork:
    """With random weights, from torch's global generator.

    layout: of the robot, whose cell size, height range and foot FootNet's fixed layers are made for.
    skeleton: of the trained leg, which FootNet needs.
    """
    if recipe.architecture == "erfnet":
        return ERFNet(len(recipe.planes))
    assert skeleton is not None, "a FootNet is that of a leg"
    return FootNet(
        recipe.planes,
        layout,
        skeleton,
        cells=recipe.cells,
        widths=recipe.widths,
        blocks=recipe.blocks,
        features=recipe.features,
        reasons=recipe.reason_weight > 0,
    )
