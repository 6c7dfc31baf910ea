"""A network while it learns: weights, their moving average, the optimiser, and one update of all three."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from footsel.dataset.samples import Samples
from footsel.footholds import LegLayout
from footsel.learning.batches import BatchEncoder
from footsel.learning.build import build_network
from footsel.learning.loss import FootholdLoss
from footsel.learning.network import FootholdNetwork, channels_last
from footsel.learning.ranks import ALONE, Ranks
from footsel.learning.recipe import Recipe
from footsel.learning.shared_layers import share_layers
from footsel.learning.skeleton import LegSkeleton


class Learner:
    """The network, the loss and Adam as a recipe asks for.

    layout: of the robot; skeleton: of the trained leg. class_weight: (14,) in the cross-entropy.
    seed: of the first weights and, after them, of every channel that is dropped; it goes to torch's global generator.
    ranks: processes that share every update; each holds the whole learner, and all stay equal.
    """

    def __init__(
        self,
        recipe: Recipe,
        layout: LegLayout,
        class_weight: NDArray[np.float32],
        seed: int,
        ranks: Ranks = ALONE,
        skeleton: LegSkeleton | None = None,
    ) -> None:
        torch.manual_seed(seed)
        self.encode = BatchEncoder(recipe.encoding(layout.height_range))
        self.recipe, self._layout, self.skeleton = recipe, layout, skeleton
        self.net = build_network(recipe, layout, skeleton)
        if ranks.count > 1:
            share_layers(self.net, ranks)
        self.net = channels_last(self.net)
        self._ranks = ranks
        self._outputs = ranks.parallel(_Outputs(self.net, reasons=recipe.reason_weight > 0))
        self.optimiser = torch.optim.Adam(self.net.parameters(), weight_decay=recipe.weight_decay, fused=True)
        #: Moving average of weights and batch statistics by name; empty if the recipe keeps none.
        self.average: dict[str, Tensor] = {}
        if recipe.ema_decay > 0:
            self.average = {name: tensor.clone() for name, tensor in self.net.state_dict().items()}
        self._class_weight = torch.from_numpy(class_weight)
        self._loss = FootholdLoss(recipe, class_weight, ranks)
        self._bfloat16 = computes_in_bfloat16(recipe.precision)

    def weights(self) -> Mapping[str, Tensor]:
        """The weights to use: the average if there is one, its logits free of the class weights if so asked.

        The minimum of the weighted cross-entropy has odds of w p: ln(w) less in the logits are the odds p of the data
        (logit adjustment, Menon et al. 2021).
        """
        weights = dict(self.average or self.net.state_dict())
        if self.recipe.calibrated:
            weights[self.net.class_bias] = weights[self.net.class_bias] - self._class_weight.log()
        return weights

    def usable_network(self) -> FootholdNetwork:
        """A network with the weights to use, ready for inference."""
        # One process asks for it; the random states of all stay equal.
        with torch.random.fork_rng(devices=[]):
            net = build_network(self.recipe, self._layout, self.skeleton)
        net.load_state_dict(self.weights())
        return channels_last(net).eval()

    @torch.no_grad()
    def adopt(self, weights: Mapping[str, Tensor]) -> None:
        """Begin at weights to use, of another training: the inverse of `weights`. The average begins there too.

        Raises RuntimeError if they are of another network; only what it learns from besides may be missing or too much.
        """
        found = self.net.load_state_dict(weights, strict=False)
        if wrong := [name for name in (*found.missing_keys, *found.unexpected_keys) if "reason" not in name]:
            raise RuntimeError(f"weights do not fit: {wrong}")
        if self.recipe.calibrated:
            self.net.get_parameter(self.net.class_bias).add_(self._class_weight.log())
        for name, tensor in self.net.state_dict().items():
            if name in self.average:
                self.average[name].copy_(tensor)

    def update(self, samples: Samples, learning_rate: float, updates_before: int) -> float:
        """One step of Adam on the maps of one batch; returns the loss before it. Processes take a share of the maps."""
        self.net.train()
        samples = samples.take(self._ranks.share(len(samples)))
        with torch.autocast("cpu", torch.bfloat16, enabled=self._bfloat16):
            logits, reasons = self._outputs(self.encode(samples))
        loss = self._loss(logits, reasons, samples)
        self.optimiser.zero_grad(set_to_none=True)
        # Gradients are averaged over the processes, but the parts of the loss add up.
        (loss * self._ranks.count).backward()  # type: ignore[no-untyped-call]
        self.optimiser.param_groups[0]["lr"] = learning_rate
        self.optimiser.step()
        self._move_average(updates_before)
        return float(self._ranks.total(loss.detach()).item())

    @torch.no_grad()
    def _move_average(self, updates_before: int) -> None:
        # Early on it moves faster, to forget the first weights.
        decay = min(self.recipe.ema_decay, (1 + updates_before) / (10 + updates_before))
        if self.average:
            for name, tensor in self.net.state_dict().items():
                if tensor.is_floating_point():
                    self.average[name].lerp_(tensor, 1 - decay)
                else:
                    self.average[name].copy_(tensor)


class _Outputs(nn.Module):
    """What a network learns from, in one forward pass, as DistributedDataParallel wants it."""

    def __init__(self, net: FootholdNetwork, reasons: bool) -> None:
        super().__init__()
        self.net, self._reasons = net, reasons

    def forward(self, maps: Tensor) -> tuple[Tensor, Tensor | None]:
        return self.net.with_reasons(maps) if self._reasons else (self.net(maps), None)


def computes_in_bfloat16(precision: str) -> bool:
    """Whether the forward pass runs in bfloat16: asked for, or "auto" on a CPU with instructions for it."""
    if precision == "auto":
        # Older versions of torch do not tell; float32 is always right.
        capabilities: Mapping[str, Any] = getattr(torch.cpu, "get_capabilities", dict)()
        return any(bool(found) for name, found in capabilities.items() if name.endswith("bf16"))
    return precision == "bfloat16"
