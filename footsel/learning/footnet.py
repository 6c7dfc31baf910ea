"""FootNet: what a foothold's label depends on, computed for every cell, then learnt layers on each cell and around it.

    place      where the foot would stand in base axes       range, self-collision, margin    geometry
    posture    how the leg is bent then                      range, margin                    inverse kinematics
    clearance  how high it then passes over the ground       terrain collision                look-ups in the map
    hip        how close the ground comes to the hip         terrain collision                look-ups in the map
    footing    how level the ground is                       terrain cost                     stencils
    cells      layers on each cell alone: from these to the label
    context    encoder to 20x20 and 10x10 of ERFNet's factorised residual layers, added on the way back

ERFNet has to learn all of it from heights, and passes the detail of 1600 cells through 5x5.
"""

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.footholds.reasons import REASON_NAMES
from footsel.learning.clearance import LegClearance
from footsel.learning.erfnet import BATCH_NORM_EPS, Downsampler, NonBottleneck1d
from footsel.learning.footing import Footing
from footsel.learning.grid import on_grid
from footsel.learning.network import FootholdNetwork
from footsel.learning.place import Place
from footsel.learning.posture import Posture
from footsel.learning.precision import own_precision
from footsel.learning.recipe import FEATURES
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt
from footsel.terrain import CELLS

#: Logits go this far from zero. More would be surer than one in a hundred thousand, which nothing needs, and what
#: rounding changes grows with them: where no leg reaches they came to 50.
LARGEST_LOGIT = 12.0
#: Dilations of the residual layers of one stage, repeated as needed; the map ends 5 cells from the middle at 10x10.
DILATIONS = (1, 2, 4, 2)


class FootNet(FootholdNetwork):
    """Local maps to class logits: (n, planes, 40, 40) -> (n, 14, 40, 40).

    planes: names of the input planes, "height" among them. layout, skeleton: of the trained leg, for the fixed layers.
    features: the fixed layers to see, among FEATURES. cells: channels of the layers on each cell alone, one or more.
    widths: channels at 20x20 and 10x10, none, one or two. blocks: residual layers at 40x40 and at these.
    reasons: whether there is a second output to learn from.
    """

    class_bias = "head.bias"
    exact_parts = ("tilt", "place", "posture", "clearance", "footing", "first")

    def __init__(
        self,
        planes: Sequence[str],
        layout: LegLayout,
        skeleton: LegSkeleton,
        cells: Sequence[int],
        widths: Sequence[int] = (),
        blocks: Sequence[int] = (0,),
        features: Sequence[str] = FEATURES,
        reasons: bool = False,
    ) -> None:
        super().__init__(len(planes))
        self._planes = tuple(planes)
        self.features = tuple(features)
        # Clearance builds on tilt and posture, whether the network sees the latter or not.
        self.tilt = Tilt(planes)
        self.place = Place(layout) if "place" in features else None
        self.posture = Posture(layout, skeleton)
        # The hip is the last of its channels.
        self.clearance = LegClearance(layout, skeleton, hip="hip" in features) if "clearance" in features else None
        self.footing = Footing(layout) if "footing" in features else None

        self.first = nn.Conv2d(len(input_names(features, skeleton)), cells[0], 1)
        self.cells = nn.Sequential(nn.ReLU(inplace=True), *(_mixed(*pair) for pair in pairwise(cells)))
        sides = [cells[-1], *widths]
        self.down = nn.ModuleList(Downsampler(*pair) for pair in pairwise(sides))
        self.up = nn.ModuleList(_mixed(coarse, fine) for fine, coarse in pairwise(sides))
        self.stages = nn.ModuleList(_stage(*stage) for stage in zip(sides, blocks, strict=True))
        self.head = nn.Conv2d(cells[-1], self.classes, 1)
        self.reason_head = nn.Conv2d(cells[-1], len(REASON_NAMES), 1) if reasons else None

    def forward(self, maps: Tensor) -> Tensor:
        """Logits of every cell's class."""
        return self._logits(self._trunk(maps))

    def with_reasons(self, maps: Tensor) -> tuple[Tensor, Tensor]:
        """Logits of every cell's class and of its reason (n, 5, 40, 40): a second target to learn from, not for use."""
        assert self.reason_head is not None, "the recipe learns reasons"
        trunk = self._trunk(maps)
        return self._logits(trunk), self.reason_head(trunk)

    def drop_training_parts(self) -> None:
        """The reasons go."""
        self.reason_head = None

    def _trunk(self, maps: Tensor) -> Tensor:
        return self._with_context(self.cells(self._first(maps)), 0)

    def _logits(self, trunk: Tensor) -> Tensor:
        logits: Tensor = self.head(trunk)
        return logits.clamp(-LARGEST_LOGIT, LARGEST_LOGIT)

    def _with_context(self, cells: Tensor, level: int) -> Tensor:
        """Residual layers of one resolution, after what the coarser ones add."""
        if level < len(self.down):
            coarser = self._with_context(self.down[level](cells), level + 1)
            cells = cells + functional.interpolate(self.up[level](coarser), scale_factor=2.0, mode="nearest")
        refined: Tensor = self.stages[level](cells)
        return refined

    def _first(self, maps: Tensor) -> Tensor:
        """(n, cells[0], 40, 40) sums of all that a cell knows, in the input's float32: it tells millimetres apart."""
        with own_precision():
            seen = self.geometry(maps)
            planes = torch.cat([seen[name].to(maps.dtype) for name in _in_order(self.features)], dim=1)
            sums: Tensor = self.first(planes.reshape(-1, planes.shape[1], CELLS, CELLS))
            return sums

    def geometry(self, maps: Tensor) -> dict[str, Tensor]:
        """What can be known of each cell without learning, (n, ..., 1600) each, by name.

        The base's tilt is in all that it decides, so a cell needs no angles.
        """
        depth = on_grid(self._plane(maps, "height"))
        known = 1 - self._plane(maps, "unknown")
        tilt = self.tilt(maps)
        seen = {"depth": depth.flatten(2), "known": known.flatten(2)}
        if self.place is not None:
            seen["place"] = self.place(seen["depth"], tilt)
        seen["posture"] = self.posture(seen["depth"], tilt)
        if self.clearance is not None:
            above = self._plane(maps, "above")
            seen["clearance"] = self.clearance(seen["posture"], tilt, depth, known, above)
        if self.footing is not None:
            seen["footing"] = self.footing(depth, known)
        return seen

    def _plane(self, maps: Tensor, name: str) -> Tensor:
        """(n, 1, 40, 40); a plane that the recipe leaves out is zero: all known, no tilt."""
        if name not in self._planes:
            return torch.zeros_like(maps[:, :1])
        index = self._planes.index(name)
        return maps[:, index : index + 1]


def input_names(features: Sequence[str], skeleton: LegSkeleton) -> list[str]:
    """What the first layer weighs of each cell, number by number: weights can be told from one another by it."""
    balls = [
        f"ball {link} {point}" for link, point in zip(skeleton.link, skeleton.balls.round(6).tolist(), strict=True)
    ]
    numbers = {
        "depth": ["depth"],
        "known": ["known"],
        "place": [f"place {number}" for number in range(Place.CHANNELS)],
        "posture": [f"posture {number}" for number in range(Posture.CHANNELS)],
        "clearance": [*balls, *(["hip"] if "hip" in features else [])],
        "footing": [f"footing {number}" for number in range(Footing.CHANNELS)],
    }
    return [number for name in _in_order(features) for number in numbers[name]]


def _in_order(features: Sequence[str]) -> list[str]:
    """What is seen of a cell; the hip comes with the clearance."""
    return ["depth", "known", *(name for name in features if name != "hip")]


def _mixed(inputs: int, outputs: int) -> nn.Sequential:
    """A layer on each cell alone."""
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 1), nn.BatchNorm2d(outputs, eps=BATCH_NORM_EPS), nn.ReLU(inplace=True)
    )


def _stage(channels: int, blocks: int) -> nn.Sequential:
    """Residual layers of one resolution."""
    return nn.Sequential(*(NonBottleneck1d(channels, dilation=DILATIONS[i % len(DILATIONS)]) for i in range(blocks)))
