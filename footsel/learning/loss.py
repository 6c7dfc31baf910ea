"""What a network is trained to minimise: the paper's weighted cross-entropy (section III-B), and what a recipe adds."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from footsel.dataset.samples import Samples
from footsel.footholds import Reason
from footsel.footholds.cost import (
    CLASSES,
    COST_BINS,
    INFEASIBLE_CLASS,
    INFEASIBLE_COST,
    class_centres,
    cost_to_class,
)
from footsel.learning.ranks import ALONE, Ranks
from footsel.learning.recipe import Recipe
from footsel.terrain import CELLS

#: c of the class weights, "In this application we used c=1.08".
CLASS_WEIGHT_C = 1.08

#: Footholds of a map that counts once: a quarter of its cells.
PLENTY = CELLS**2 / 4

#: Class of every possible 8-bit label. Unknown cells carry 255, so they are learnt as infeasible.
LABEL_CLASS = cost_to_class(np.arange(256))


def class_shares(cost: NDArray[np.uint8]) -> NDArray[np.float64]:
    """(14,) share of each class among all cells of the labels `cost` (n, 40, 40)."""
    labels = np.bincount(cost.reshape(-1), minlength=256)
    return np.bincount(LABEL_CLASS, weights=labels, minlength=CLASSES) / max(cost.size, 1)


def class_weights(shares: NDArray[np.float64], kind: str) -> NDArray[np.float32]:
    """(14,) weight of each class in the cross-entropy.

    kind: "paper" for `1 / ln(c + p)` (the paper's equation 2, after ENet), 1.37 for a class that is everywhere to 12.99
        for one that is nowhere; "none" for ones.
    """
    if kind == "none":
        return np.ones(CLASSES, dtype=np.float32)
    return (1 / np.log(CLASS_WEIGHT_C + shares)).astype(np.float32)


def targets(spread: float) -> NDArray[np.float32]:
    """(256, 14) probabilities to be learnt for every possible 8-bit label; each row sums to 1.

    spread: 0 for all in the label's class. Above it, soft ordinal labels (SORD, Diaz and Marathe, CVPR 2019): feasible
        classes share in it by exp(-d^2 / 2), d the distance of a class's centre from the label's cost in units of
        `spread` classes. A neighbouring class is then less wrong than a far one, and the classes' mean resolves finer
        than one of them. "Infeasible" lies on no scale with the others and stays apart.
    """
    if spread == 0:
        return np.eye(CLASSES, dtype=np.float32)[LABEL_CLASS]
    distance = (np.arange(INFEASIBLE_COST)[:, None] - class_centres()) * COST_BINS / INFEASIBLE_COST / spread
    closeness = np.exp(-(distance**2) / 2 + (distance**2).min(axis=1, keepdims=True) / 2)
    table = np.zeros((INFEASIBLE_COST + 1, CLASSES), dtype=np.float32)
    table[:INFEASIBLE_COST, :COST_BINS] = closeness / closeness.sum(axis=1, keepdims=True)
    table[INFEASIBLE_COST, INFEASIBLE_CLASS] = 1
    return table


def map_weights(reason: Tensor, most: float) -> Tensor:
    """(n,) how often each map counts, up to `most`: the square root of how rare footholds are in it.

    reason: (n, 40, 40). A map of which a quarter is feasible counts once. Where nearly nothing is, one wrong cell makes
    a wrong pick, or hides the only one; where much is, it hardly matters.
    """
    footholds = (reason == Reason.FEASIBLE).sum(dim=(1, 2)).clamp(min=1)
    return (PLENTY / footholds).sqrt().clamp(max=most)


class FootholdLoss:
    """Cross-entropy of the classes, averaged over all cells by their weights, plus that of the reasons.

    class_weight: (14,). The minimum has the odds w p, which calibrated logits are corrected for. `collision_weight`
    counts each cell that collides with terrain as so many: no constant per class undoes that, so where a collision
    is possible the network's p(infeasible) is higher than in the data, and the threshold is chosen after it. `scarcity`
    is the most that a map counts (map_weights); at 1 all count alike.
    ranks: processes that share a batch; each gets its part of the loss, the parts add up to that of the batch.
    """

    def __init__(self, recipe: Recipe, class_weight: NDArray[np.float32], ranks: Ranks = ALONE) -> None:
        self._ranks = ranks
        self._weighted_targets = torch.from_numpy(targets(recipe.ordinal) * class_weight)
        reason_factor = torch.ones(len(Reason))
        reason_factor[Reason.TERRAIN_COLLISION] = recipe.collision_weight
        self._reason_factor = reason_factor
        self._reason_weight = recipe.reason_weight
        self._scarcity = recipe.scarcity

    def __call__(self, logits: Tensor, reason_logits: Tensor | None, samples: Samples) -> Tensor:
        """logits: (n, 14, 40, 40). reason_logits: (n, 5, 40, 40), None if reasons are not learnt."""
        reason = torch.from_numpy(samples.reason).long()  # (n, 40, 40)
        weighted = self._weighted_targets[torch.from_numpy(samples.cost).long()]  # (n, 40, 40, 14)
        weighted = weighted * self._reason_factor[reason][..., None]
        if self._scarcity > 1:
            weighted = weighted * map_weights(reason, self._scarcity)[:, None, None, None]
        surprise = -functional.log_softmax(logits.float(), dim=1).permute(0, 2, 3, 1)
        loss = (weighted * surprise).sum() / self._ranks.total(weighted.sum())
        if reason_logits is not None:
            error = functional.cross_entropy(reason_logits.float(), reason, self._reason_factor, reduction="sum")
            loss = loss + self._reason_weight * error / self._ranks.total(self._reason_factor[reason].sum())
        return loss
