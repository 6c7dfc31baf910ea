"""Where a leg is does not depend on the engine that computes it: a network tells half a millimetre apart."""

import numpy as np
import pytest
import torch
from torch import Tensor, nn

from footsel.exporting.onnx_file import to_onnx
from footsel.exporting.parity import graph_logits
from footsel.exporting.trial_maps import trial_maps
from footsel.footholds import LegLayout
from footsel.footholds.encoding import InputEncoding
from footsel.learning.clearance import LegClearance
from footsel.learning.posture import Posture
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt
from footsel.robot import load_robot

PLANES = ("height", "roll", "pitch")


class LegGeometry(nn.Module):
    """Maps -> (n, 10 + 3 balls, 1600) posture and ball centres in the maps' type."""

    def __init__(self, layout: LegLayout, skeleton: LegSkeleton) -> None:
        super().__init__()
        self.tilt, self.posture = Tilt(PLANES), Posture(layout, skeleton)
        self.clearance = LegClearance(layout, skeleton)

    def forward(self, maps: Tensor) -> Tensor:
        """As above."""
        tilt = self.tilt(maps)
        posture = self.posture(maps[:, :1].flatten(2), tilt)
        centres = self.clearance.centres(posture, tilt, maps.dtype).unflatten(2, (-1, 1600)).flatten(1, 2)
        return torch.cat([posture.to(maps.dtype), centres], dim=1)


@pytest.mark.parametrize("leg", ["LF", "LH"])
def test_engines_differ_in_the_last_bit_at_most(anymal_layout, leg):
    """And next to never in that; in float32 they differ in a third of the values, by up to a thousand units of it."""
    geometry = LegGeometry(anymal_layout, LegSkeleton.of(load_robot("anymal_b"), leg)).eval()
    maps = trial_maps(anymal_layout, leg, 20, seed=8)
    planes = InputEncoding(PLANES, False, anymal_layout.height_range).encode(maps.heights, maps.roll, maps.pitch)
    with torch.inference_mode():
        expected = geometry(torch.from_numpy(planes)).numpy()
    found = graph_logits(to_onnx(geometry, len(PLANES)))(planes)
    difference = np.abs(found - expected) / np.maximum(np.spacing(np.abs(expected)), 2.0**-26)
    assert difference.max() <= 1 and (difference > 0).mean() < 1e-6
