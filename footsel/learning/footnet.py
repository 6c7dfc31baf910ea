"""FootNet: ERFNet's residual layers around what a foothold's label depends on, at full resolution from end to end.

    place      where the foot would stand in base axes: range, self-collision, margin    cell by cell
    clearance  how high the leg then passes over the ground: terrain collision           inverse kinematics
    relief     drops to the neighbours: terrain cost; rises around                       constant stencils
    context    encoder to 20x20 and 10x10 of factorised, dilated residual layers, skips added on the way back

ERFNet passes the detail of 1600 cells through 5x5; here every cell keeps its own, and the context is added to it.
"""

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from footsel.footholds import LegLayout
from footsel.footholds.reasons import REASON_NAMES
from footsel.learning.clearance import LegClearance
from footsel.learning.erfnet import BATCH_NORM_EPS, Downsampler, NonBottleneck1d
from footsel.learning.float32 import float32
from footsel.learning.network import FootholdNetwork
from footsel.learning.place import Place
from footsel.learning.recipe import FEATURES
from footsel.learning.relief import Drops, FootSurface, KnownShares, Rises
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import tilt_matrix

#: Dilations of the residual layers of one stage, repeated as needed; the map ends 5 cells from the middle at 10x10.
DILATIONS = (1, 2, 4, 2)


class FootNet(FootholdNetwork):
    """Local maps to class logits: (n, planes, 40, 40) -> (n, 14, 40, 40).

    planes: names of the input planes, "height" among them. layout: whose legs; sets the scale of the fixed layers.
    widths: channels of the first layer on each cell alone, then at 40x40, 20x20 and 10x10. blocks: residual layers at
    these three. features: among FEATURES. skeleton: of the trained leg, for "clearance".
    reasons: whether there is a second output to learn from.
    """

    class_bias = "head.bias"
    exact_parts = ("foot_surface", "drops", "rises", "known_shares", "clearance", "from_itself")

    def __init__(
        self,
        planes: Sequence[str],
        layout: LegLayout,
        widths: Sequence[int],
        blocks: Sequence[int],
        features: Sequence[str] = FEATURES,
        reasons: bool = False,
        skeleton: LegSkeleton | None = None,
    ) -> None:
        super().__init__(len(planes))
        self._planes = tuple(planes)
        hidden, fine, middle, coarse = widths
        # Drops alone look at the foot's surface.
        self.foot_surface = FootSurface(layout) if "drops" in features else None
        self.drops = Drops(layout.height_range) if "drops" in features else None
        self.rises = Rises(layout.height_range) if "rises" in features else None
        self.place = Place(layout) if "place" in features else None
        self.clearance = None
        if "clearance" in features:
            assert skeleton is not None, "clearance is that of a leg"
            self.clearance = LegClearance(layout, skeleton)

        # One layer over all that a cell knows, in parts: in onnxruntime a sum costs less than joining the parts.
        self.known_shares = KnownShares()
        itself = self.in_channels + KnownShares.CHANNELS
        itself += Place.CHANNELS if self.place is not None else 0
        itself += self.clearance.channels if self.clearance is not None else 0
        self.from_itself = nn.Conv2d(itself, hidden, 1)
        self.from_relief = nn.ModuleList(nn.Conv2d(layer.CHANNELS, hidden, 1, bias=False) for layer in self._relief())
        self.join = nn.Sequential(
            nn.ReLU(inplace=True),
            nn.Conv2d(hidden, fine, 1),
            nn.BatchNorm2d(fine, eps=BATCH_NORM_EPS),
            nn.ReLU(inplace=True),
        )
        self.down = nn.ModuleList([Downsampler(fine, middle), Downsampler(middle, coarse)])
        self.up = nn.ModuleList([_Raise(middle, fine), _Raise(coarse, middle)])
        self.fine, self.middle, self.coarse = (_stage(*stage) for stage in zip(widths[1:], blocks, strict=True))
        self.head = nn.Conv2d(fine, self.classes, 1)
        self.reason_head = nn.Conv2d(fine, len(REASON_NAMES), 1) if reasons else None

    def forward(self, maps: Tensor) -> Tensor:
        """Logits of every cell's class."""
        logits: Tensor = self.head(self._trunk(maps))
        return logits

    def with_reasons(self, maps: Tensor) -> tuple[Tensor, Tensor]:
        """Logits of every cell's class and of its reason (n, 5, 40, 40): a second target to learn from, not for use."""
        assert self.reason_head is not None, "the recipe learns reasons"
        trunk = self._trunk(maps)
        return self.head(trunk), self.reason_head(trunk)

    def drop_training_parts(self) -> None:
        """The reasons go."""
        self.reason_head = None

    def _trunk(self, maps: Tensor) -> Tensor:
        cells = self.join(self._cells(maps))  # (n, fine, 40, 40)
        half = self.down[0](cells)
        quarter = self.coarse(self.down[1](half))
        half = self.middle(half + self.up[1](quarter))
        trunk: Tensor = self.fine(cells + self.up[0](half))
        return trunk

    def _cells(self, maps: Tensor) -> Tensor:
        """(n, hidden, 40, 40) what each cell knows by itself and from the fixed stencils."""
        depth = self._plane(maps, "height")
        known = 1 - self._plane(maps, "unknown")
        with float32():
            itself = [maps, self.known_shares(known)]
            if self.place is not None:
                tilt = tilt_matrix(*(self._plane(maps, name)[:, :, :1, :1] for name in ("roll", "pitch")))
                itself.append(self.place(depth, tilt))
                if self.clearance is not None:
                    itself.append(self.clearance(itself[-1], depth, known, tilt))
            cells: Tensor = self.from_itself(torch.cat(itself, dim=1))
        foot = depth if self.foot_surface is None else self.foot_surface(depth, known)
        for layer, weigh in zip(self._relief(), self.from_relief, strict=True):
            cells = cells + weigh(layer(foot if layer is self.drops else depth, known))
        return cells

    def _relief(self) -> list[Drops | Rises]:
        return [layer for layer in (self.drops, self.rises) if layer is not None]

    def _plane(self, maps: Tensor, name: str) -> Tensor:
        """(n, 1, 40, 40); a plane that the recipe leaves out is zero: all known, no tilt."""
        if name not in self._planes:
            return torch.zeros_like(maps[:, :1])
        index = self._planes.index(name)
        return maps[:, index : index + 1]


class _Raise(nn.Module):
    """Twice the side: channels are mixed, then every cell becomes four. The residual layers that follow refine it."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.mix = nn.Conv2d(inputs, outputs, 1)
        self.norm = nn.BatchNorm2d(outputs, eps=BATCH_NORM_EPS)

    def forward(self, maps: Tensor) -> Tensor:
        """(n, inputs, h, w) -> (n, outputs, 2 h, 2 w)."""
        return functional.interpolate(functional.relu(self.norm(self.mix(maps))), scale_factor=2.0, mode="nearest")


def _stage(channels: int, blocks: int) -> nn.Sequential:
    """Residual layers of one resolution."""
    return nn.Sequential(*(NonBottleneck1d(channels, dilation=DILATIONS[i % len(DILATIONS)]) for i in range(blocks)))
