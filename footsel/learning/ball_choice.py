"""Which balls of a leg's skeleton a network gets: those that tell collisions with terrain on the training maps."""

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray

from footsel.dataset.samples import Samples
from footsel.footholds import LegLayout, Reason
from footsel.footholds.encoding import PLANES, InputEncoding
from footsel.learning.clearance import LegClearance
from footsel.learning.posture import Posture
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt

#: Training maps that are looked at, spread over all of them.
MAPS = 200


def with_best_balls(
    skeleton: LegSkeleton, samples: Samples, layout: LegLayout, count: int, hip: bool = False
) -> LegSkeleton:
    """The skeleton with at most `count` balls, 0 for all, chosen one by one: each makes the least clearance err least.

    A cell in range errs if the least clearance of the balls says another than the label whether the leg collides there,
    by the threshold that suits best. Every ball costs a look-up per cell; for ANYmal five of thirteen do nearly as well
    as all of them (docs/learning.md).
    hip: whether the network sees the body around the hip besides.
    """
    if count == 0 or count >= len(skeleton.radius):
        return skeleton
    clearance, collides = _seen(skeleton, samples, layout, hip)
    seen_anyway = list(range(len(skeleton.radius), clearance.shape[1]))
    chosen: list[int] = []
    while len(chosen) < count:
        left = [ball for ball in range(len(skeleton.radius)) if ball not in chosen]
        errors = [_errors(clearance[:, [*seen_anyway, *chosen, ball]].min(axis=1), collides) for ball in left]
        chosen.append(left[int(np.argmin(errors))])
    kept = sorted(chosen)
    radius, rises = skeleton.radius[kept], skeleton.rises
    if rises is not None:
        rises = rises[np.isin(np.unique(skeleton.radius), radius)]
    return replace(skeleton, link=skeleton.link[kept], balls=skeleton.balls[kept], radius=radius, rises=rises)


def _seen(
    skeleton: LegSkeleton, samples: Samples, layout: LegLayout, hip: bool = False
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """(cells, balls and hip) clearances and (cells,) whether the leg collides, of the cells in range on some maps."""
    some = samples.spread(MAPS)
    encoding = InputEncoding(PLANES, False, layout.height_range)
    maps = torch.from_numpy(encoding.encode(some.heights(), some.roll, some.pitch))
    height, unknown, above = maps[:, :1], maps[:, 1:2], maps[:, -1:]
    tilt = Tilt(encoding.planes)(maps)
    posture = Posture(layout, skeleton)(height.flatten(2), tilt)
    clearance = LegClearance(layout, skeleton, hip=hip)(posture, tilt, height, 1 - unknown, above).mT.numpy()
    collides = some.reason == Reason.TERRAIN_COLLISION
    in_range = (collides | (some.reason == Reason.FEASIBLE)).reshape(len(some), -1)
    return clearance[in_range], collides.reshape(len(some), -1)[in_range]


def _errors(least: NDArray[np.float32], collides: NDArray[np.bool_]) -> int:
    """Cells that the best threshold on `least` (cells,) calls wrongly."""
    hits = collides[np.argsort(least, kind="stable")]
    # Below a threshold that lies after the first n cells all collide, above it none does.
    wrong = np.cumsum(~hits) + (hits.sum() - np.cumsum(hits))
    return int(min(wrong.min(initial=len(hits)), hits.sum()))
