"""Where a skeleton's balls lie and how far they reach aside: fitted to what collides on the training maps.

Bodies are no balls, and a look-up blends the heights of four cells where the oracle has triangles. Which places and
rings make up for that best is left to the gradient: a small network tells from clearances and posture whether the leg
collides, as the one to be trained will, and the balls learn with it. They cost nothing more to look up.
"""

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.func import functional_call
from torch.nn import functional
from torch.optim.lr_scheduler import OneCycleLR
from tqdm import tqdm

from footsel.dataset.samples import Samples
from footsel.footholds import LegLayout, Reason
from footsel.footholds.encoding import PLANES, InputEncoding
from footsel.learning.clearance import LegClearance, ball_sums
from footsel.learning.posture import Posture
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.tilt import Tilt

#: Training maps that are looked at, spread over all of them; passes over these, and maps per update.
MAPS, PASSES, BATCH = 4000, 8, 8
#: Of the small network's two layers.
WIDTH = 64
#: Highest learning rates: of the network's weights, of places in [m], of rises in units of the largest clearance.
NET_RATE, PLACE_RATE, RISE_RATE = 1e-2, 1e-3, 1e-2


def with_fitted_balls(
    skeleton: LegSkeleton, samples: Samples, layout: LegLayout, passes: int = PASSES, silent: bool = True
) -> LegSkeleton:
    """The skeleton with its balls moved and their rises changed; the same for the same maps.

    silent: without a progress bar.
    """
    some = samples.spread(MAPS)
    encode = InputEncoding(PLANES, False, layout.height_range).encode
    with torch.random.fork_rng(devices=[]), torch.enable_grad():
        torch.manual_seed(0)
        trial = CollisionTrial(layout, skeleton)
        learnt = [list(trial.net.parameters()), [trial.balls], [trial.rises]]
        optimiser = torch.optim.Adam([{"params": parameters} for parameters in learnt])
        steps = passes * -(-len(some) // BATCH)
        # No fewer than the schedule can be made for.
        schedule = OneCycleLR(optimiser, [NET_RATE, PLACE_RATE, RISE_RATE], total_steps=max(steps, 4))
        bar = tqdm(total=passes * len(some), desc="balls", unit="map", disable=True if silent else None)
        for _ in range(passes):
            for batch in torch.split(torch.randperm(len(some)), BATCH):
                maps = some.take(batch.numpy())
                loss = trial.loss(torch.from_numpy(encode(maps.heights(), maps.roll, maps.pitch)), maps.reason)
                optimiser.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                optimiser.step()
                schedule.step()
                bar.update(len(maps))
        bar.close()
    return trial.skeleton()


class CollisionTrial(nn.Module):
    """A small network that tells from clearances and posture whether the leg collides, and balls that learn with it."""

    def __init__(self, layout: LegLayout, skeleton: LegSkeleton) -> None:
        super().__init__()
        self._skeleton = skeleton
        self._tilt, self._posture = Tilt(PLANES), Posture(layout, skeleton)
        self._clearance = LegClearance(layout, skeleton)
        self.balls = nn.Parameter(torch.from_numpy(skeleton.balls.copy()))
        self.rises = nn.Parameter(self._clearance.get_buffer("rises").clone())
        # What places a ball is linear in where it lies: sums for one in the axes' origin, and more for each metre.
        origin, *ends = (_sums(skeleton, point) for point in (np.zeros(3), *np.eye(3)))
        self._origin = tuple(map(torch.from_numpy, origin))
        self._per_metre = tuple(
            torch.from_numpy(np.stack([end[part] - start for end in ends])) for part, start in enumerate(origin)
        )
        inputs = len(skeleton.radius) + Posture.CHANNELS
        self.net = nn.Sequential(
            nn.Conv1d(inputs, WIDTH, 1), nn.ReLU(), nn.Conv1d(WIDTH, WIDTH, 1), nn.ReLU(), nn.Conv1d(WIDTH, 1, 1)
        )

    def forward(self, maps: Tensor) -> Tensor:
        """Input of FootNet with PLANES -> (n, 1600) logits of a collision."""
        depth, known, tilt = maps[:, :1], 1 - maps[:, 1:2], self._tilt(maps)
        posture = self._posture(depth.flatten(2), tilt)
        place, along_w = (
            start + torch.einsum("mk,kmdc->mdc", self.balls, per_metre)
            for start, per_metre in zip(self._origin, self._per_metre, strict=True)
        )
        constants = {
            "place": place.transpose(0, 1).flatten(1),
            "along_w": along_w[:, 0],
            "rises": self.rises,
        }
        clearance = functional_call(self._clearance, constants, (posture, tilt, depth, known))
        logits: Tensor = self.net(torch.cat([clearance, posture.to(maps.dtype)], dim=1))
        return logits[:, 0]

    def loss(self, maps: Tensor, reason: NDArray[np.uint8]) -> Tensor:
        """Mean cross-entropy over the cells in range. reason: (n, 40, 40) of the labels."""
        labels = torch.from_numpy(reason).flatten(1)
        collides = labels == int(Reason.TERRAIN_COLLISION)
        in_range = collides | (labels == int(Reason.FEASIBLE))
        found, expected = self(maps)[in_range], collides[in_range].to(maps.dtype)
        # Of no cell at all it is nothing, and no division by zero.
        total = functional.binary_cross_entropy_with_logits(found, expected, reduction="sum")
        return total / max(len(found), 1)

    def skeleton(self) -> LegSkeleton:
        """The leg with the balls as they are now."""
        rises = self.rises.detach().double().flatten(1).numpy() * self._clearance.unit
        return replace(self._skeleton, balls=self.balls.detach().numpy(), rises=rises)


def _sums(skeleton: LegSkeleton, point: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """`ball_sums` (m, 3, 10) and (m, 1, 10) if all balls lay at `point`, from their axes."""
    count = len(skeleton.radius)
    place, along_w, _ = ball_sums(replace(skeleton, balls=np.tile(point, (count, 1))))
    return place.reshape(3, count, -1).swapaxes(0, 1).copy(), along_w[:, None].copy()
