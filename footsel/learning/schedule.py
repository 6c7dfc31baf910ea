"""The learning rate as a function of progress alone, so a resumed training cannot lose its place."""

import math

from footsel.learning.recipe import Recipe

#: One cycle after Smith and Topin 2018 with the defaults of PyTorch's OneCycleLR: where the peak lies, how far below it
#: the cycle starts, and how far below its start it ends.
PEAK_AT, START_BELOW, END_BELOW = 0.3, 25.0, 1e4


def decay_per_epoch(recipe: Recipe) -> float:
    """Factor per epoch that ends where `decay_epochs` epochs of `decay` would, in the recipe's epochs."""
    assert recipe.decay is not None and recipe.decay_epochs is not None, "checked by the recipe"
    return float(recipe.decay ** (recipe.decay_epochs / recipe.epochs))


def learning_rate(recipe: Recipe, epoch: int, batch: int, batches: int) -> float:
    """Learning rate of update `batch` of `batches` in `epoch`, both counted from 0."""
    if recipe.schedule == "exponential":
        return recipe.learning_rate * decay_per_epoch(recipe) ** epoch
    peak, start = recipe.learning_rate, recipe.learning_rate / START_BELOW
    progress = (epoch * batches + batch) / max(recipe.epochs * batches - 1, 1)
    if progress < PEAK_AT:
        return _cosine(start, peak, progress / PEAK_AT)
    return _cosine(peak, start / END_BELOW, (progress - PEAK_AT) / (1 - PEAK_AT))


def _cosine(begin: float, end: float, share: float) -> float:
    """From `begin` to `end` along half a cosine."""
    return end + (begin - end) * (1 + math.cos(math.pi * share)) / 2
