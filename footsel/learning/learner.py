"""A network while it learns: weights, their moving average, the optimiser, and one update of all three."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from footsel.dataset.samples import Samples
from footsel.footholds.encoding import InputEncoding
from footsel.learning.batches import BatchEncoder, label_classes
from footsel.learning.erfnet import ERFNet, channels_last
from footsel.learning.recipe import Recipe


class Learner:
    """ERFNet and Adam as a recipe asks for.

    encoding: the input. class_weight: (14,) in the cross-entropy.
    seed: of the first weights and, after them, of every channel that is dropped; it goes to torch's global generator.
    """

    def __init__(self, recipe: Recipe, encoding: InputEncoding, class_weight: NDArray[np.float32], seed: int) -> None:
        torch.manual_seed(seed)
        self.encode = BatchEncoder(encoding)
        self.net = channels_last(ERFNet(len(encoding.planes)))
        self.optimiser = torch.optim.Adam(self.net.parameters(), weight_decay=recipe.weight_decay, fused=True)
        #: Moving average of weights and batch statistics by name; empty if the recipe keeps none.
        self.average: dict[str, Tensor] = {}
        if recipe.ema_decay > 0:
            self.average = {name: tensor.clone() for name, tensor in self.net.state_dict().items()}
        self._average_decay = recipe.ema_decay
        self._class_weight = torch.from_numpy(class_weight)
        self._calibrated = recipe.calibrated
        self._bfloat16 = computes_in_bfloat16(recipe.precision)

    def weights(self) -> Mapping[str, Tensor]:
        """The weights to use: the average if there is one, its logits free of the class weights if so asked.

        The minimum of the weighted cross-entropy has odds of w p: ln(w) less in the logits are the odds p of the data
        (logit adjustment, Menon et al. 2021).
        """
        weights = dict(self.average or self.net.state_dict())
        if self._calibrated:
            bias = f"decoder.{len(self.net.decoder) - 1}.bias"
            weights[bias] = weights[bias] - self._class_weight.log()
        return weights

    @torch.no_grad()
    def adopt(self, weights: Mapping[str, Tensor]) -> None:
        """Begin at weights to use, of another training: the inverse of `weights`. The average begins there too."""
        self.net.load_state_dict(weights)
        if self._calibrated:
            bias = self.net.decoder[-1].bias
            bias += self._class_weight.log()  # type: ignore[operator]
        for name, tensor in self.net.state_dict().items():
            if name in self.average:
                self.average[name].copy_(tensor)

    def update(self, samples: Samples, learning_rate: float, updates_before: int) -> float:
        """One step of Adam on the maps of one batch; returns the loss before it."""
        self.net.train()
        with torch.autocast("cpu", torch.bfloat16, enabled=self._bfloat16):
            logits = self.net(self.encode(samples))  # (n, 14, 40, 40)
        loss = functional.cross_entropy(logits.float(), label_classes(samples), self._class_weight)
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        self.optimiser.param_groups[0]["lr"] = learning_rate
        self.optimiser.step()
        self._move_average(updates_before)
        return float(loss.item())

    @torch.no_grad()
    def _move_average(self, updates_before: int) -> None:
        # Early on it moves faster, to forget the first weights.
        decay = min(self._average_decay, (1 + updates_before) / (10 + updates_before))
        if self.average:
            for name, tensor in self.net.state_dict().items():
                if tensor.is_floating_point():
                    self.average[name].lerp_(tensor, 1 - decay)
                else:
                    self.average[name].copy_(tensor)


def computes_in_bfloat16(precision: str) -> bool:
    """Whether the forward pass runs in bfloat16: asked for, or "auto" on a CPU with instructions for it."""
    if precision == "auto":
        # Older versions of torch do not tell; float32 is always right.
        capabilities: Mapping[str, Any] = getattr(torch.cpu, "get_capabilities", dict)()
        return any(bool(found) for name, found in capabilities.items() if name.endswith("bf16"))
    return precision == "bfloat16"
