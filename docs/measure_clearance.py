"""How well the leg's clearance tells collisions with terrain, by what it is made of: docs/results/clearance.json.

python docs/measure_clearance.py DATA

DATA is a dataset of the recipe footsel. For each row of VARIANTS a small network learns, from clearances and posture
alone, which of the cells in range collide: a trial of the geometry in seconds instead of a training in an hour.
"""

import argparse
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.nn import functional
from tqdm import tqdm

from footsel.dataset import Samples, open_dataset
from footsel.errors import FootselError
from footsel.files import write_json
from footsel.footholds import Reason
from footsel.footholds.encoding import PLANES, InputEncoding
from footsel.learning.ball_choice import with_best_balls
from footsel.learning.ball_fit import with_fitted_balls
from footsel.learning.clearance import BEYOND, FALL, LegClearance
from footsel.learning.posture import Posture
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt
from footsel.legs import TRAINED_LEG
from footsel.robot import load_robot

RESULT = Path(__file__).resolve().parent / "results" / "clearance.json"
PAIR = "front"
#: Maps, spread over the dataset; the last quarter judges. Share of their cells in range that is kept.
MAPS, VALIDATION, KEPT = 4000, 0.25, 0.5
BALLS = 5


@dataclass(frozen=True)
class Variant:
    """A way to compute the clearance.

    balls: 0 for all. beyond, fall: rings beyond them. thickness: of the balls beside the usual. fitted: if they are.
    hip: whether the body around the hip is seen besides; above: with the ground above it.
    """

    balls: int = BALLS
    beyond: int = BEYOND
    fall: float = FALL
    thickness: float = 1.0
    fitted: bool = False
    hip: bool = False
    above: bool = True


VARIANTS: Mapping[str, Variant] = {
    "five balls, a ring beyond": Variant(),
    "the same, fitted": Variant(fitted=True),
    "nothing beyond": Variant(beyond=0),
    "two rings beyond": Variant(beyond=2),
    "a ring that falls half as steeply": Variant(fall=FALL / 2),
    "balls a tenth thinner": Variant(thickness=1 / 1.1),
    "balls a tenth thicker": Variant(thickness=1.1),
    "six balls": Variant(balls=6),
    "all balls": Variant(balls=0),
    "all balls, nothing beyond": Variant(balls=0, beyond=0),
    "three balls, fitted": Variant(balls=3, fitted=True),
    "all balls, fitted": Variant(balls=0, fitted=True),
    "four balls and the hip": Variant(balls=4, hip=True),
    "the same, but no ground above the hip": Variant(balls=4, hip=True, above=False),
}
#: A map with fewer footholds has few.
FEW = 100
#: Shares of the feasible cells that are given away, at which variants are compared.
LOST = (0.01, 0.03)
WIDTH, PASSES, BATCH, RATE = 64, 6, 2048, 1e-2


def main() -> int:
    """All variants, one after the other."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", metavar="DATA", type=Path)
    args = parser.parse_args()
    try:
        dataset = open_dataset(args.data)
        samples = dataset.load(PAIR)
    except FootselError as error:
        print(f"measure_clearance.py: error: {error}", file=sys.stderr)
        return 2
    samples = samples.spread(MAPS)
    torch.set_num_threads(1)
    rows = {name: measured(samples, variant) for name, variant in tqdm(VARIANTS.items(), disable=None)}
    write_json(RESULT, {"dataset_sha256": dataset.sha256, "maps": len(samples), "variants": rows})
    return 0


def measured(samples: Samples, variant: Variant) -> dict[str, Any]:
    """What a small network makes of one variant."""
    collides = samples.reason == Reason.TERRAIN_COLLISION
    in_range = collides | (samples.reason == Reason.FEASIBLE)
    kept = in_range & (np.random.default_rng(0).random(in_range.shape) < KEPT)
    seen = torch.from_numpy(_seen(samples, kept, variant))
    label = torch.from_numpy(collides[kept].astype(np.float32))
    of_map = np.nonzero(kept)[0]
    judged = torch.from_numpy(of_map >= (1 - VALIDATION) * len(samples))
    footholds = (samples.reason == Reason.FEASIBLE).sum(axis=(1, 2))
    few = ((footholds > 0) & (footholds < FEW))[of_map[judged.numpy()]]
    net = _trained(seen[~judged], label[~judged])
    with torch.inference_mode():
        doubt = torch.sigmoid(net(seen[judged])[:, 0]).numpy()
    wrong = label[judged].numpy() > 0
    errors = (doubt > 0.5) != wrong
    return {
        "cells": int(judged.sum()),
        "errors": float(errors.mean()),
        "errors_where_few": float(errors[few].mean()),
        "taken_for_feasible": {
            str(lost): float((doubt[wrong] < np.quantile(doubt[~wrong], 1 - lost)).mean()) for lost in LOST
        },
    }


def _seen(samples: Samples, kept: NDArray[np.bool_], variant: Variant) -> NDArray[np.float32]:
    """(cells, planes) clearances and posture of the cells that are kept."""
    robot = load_robot()
    layout, whole = robot.layout, LegSkeleton.of(robot, TRAINED_LEG[PAIR])
    skeleton = with_best_balls(whole, samples, layout, variant.balls, variant.hip)
    skeleton = replace(skeleton, radius=variant.thickness * skeleton.radius)
    if variant.fitted:
        # Not to those that judge.
        skeleton = with_fitted_balls(skeleton, samples.take(slice(int((1 - VALIDATION) * len(samples)))), layout)
    layer = LegClearance(layout, skeleton, variant.beyond, variant.fall, variant.hip)
    encoding = InputEncoding(PLANES, False, layout.height_range)
    parts = []
    for start in range(0, len(samples), 100):
        some = samples.take(slice(start, start + 100))
        maps = torch.from_numpy(encoding.encode(some.heights(), some.roll, some.pitch))
        depth, known, tilt = maps[:, :1], 1 - maps[:, 1:2], Tilt(PLANES)(maps)
        posture = Posture(layout, skeleton)(depth.flatten(2), tilt)
        above = maps[:, PLANES.index("above"), None] * variant.above
        planes = torch.cat([layer(posture, tilt, depth, known, above), posture.float()], dim=1)
        parts.append(planes.mT.numpy()[kept[start : start + 100].reshape(len(some), -1)])
    return np.concatenate(parts)


def _trained(seen: torch.Tensor, label: torch.Tensor) -> nn.Module:
    torch.manual_seed(0)
    net = nn.Sequential(
        nn.Linear(seen.shape[1], WIDTH), nn.ReLU(), nn.Linear(WIDTH, WIDTH), nn.ReLU(), nn.Linear(WIDTH, 1)
    )
    steps = PASSES * len(label) // BATCH
    optimiser = torch.optim.Adam(net.parameters(), RATE)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, RATE, total_steps=steps)
    for _ in range(steps):
        some = torch.randint(len(label), (BATCH,))
        loss = functional.binary_cross_entropy_with_logits(net(seen[some])[:, 0], label[some])
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    return net


if __name__ == "__main__":
    sys.exit(main())
