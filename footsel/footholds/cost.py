"""The paper's cost of a foothold, the fourteen classes a network tells apart, and how classes become costs again."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Cost of every cell that fails a constraint; a feasible cell is held to one less.
INFEASIBLE_COST = 255
MAX_FEASIBLE_COST = 254

#: Thirteen equal bins of the cost and one class for infeasible cells.
COST_BINS = 13
INFEASIBLE_CLASS = COST_BINS
CLASSES = COST_BINS + 1


def foothold_cost(margin_cost: ArrayLike, terrain_cost: ArrayLike) -> NDArray[np.float64]:
    """Cost of feasible cells, `(c_k + 2 c_m) / 3 * 255` held to 254 (the paper's equation 1).

    margin_cost: c_k in [0, 1], 0 at the largest kinematic margin.
    terrain_cost: c_m in [0, 1], 0 on flat ground.
    """
    cost = (np.asarray(margin_cost, dtype=np.float64) + 2 * np.asarray(terrain_cost, dtype=np.float64)) / 3 * 255
    return np.minimum(cost, MAX_FEASIBLE_COST)


def cost_to_class(cost: ArrayLike) -> NDArray[np.uint8]:
    """Class of a cost in [0, 255]: `floor(cost * 13 / 255)` for feasible cells, 13 for 255."""
    cost = np.asarray(cost, dtype=np.float64)
    bins = np.minimum(cost * COST_BINS / INFEASIBLE_COST, COST_BINS - 1).astype(np.uint8)
    return np.where(cost >= INFEASIBLE_COST, np.uint8(INFEASIBLE_CLASS), bins)


def class_centres() -> NDArray[np.float32]:
    """(13,) cost in the middle of each feasible class."""
    return ((np.arange(COST_BINS) + 0.5) * INFEASIBLE_COST / COST_BINS).astype(np.float32)


def softmax(logits: ArrayLike, axis: int) -> NDArray[np.float32]:
    """Probabilities along `axis`."""
    logits = np.asarray(logits, dtype=np.float32)
    exponentials = np.exp(logits - logits.max(axis=axis, keepdims=True))
    return np.asarray(exponentials / exponentials.sum(axis=axis, keepdims=True))


def expected_cost(probabilities: ArrayLike) -> NDArray[np.float32]:
    """Mean cost over all classes, that of an infeasible cell included; resolves finer than a bin.

    A doubtful cell is dear in proportion, so a choice keeps away from it before any threshold forbids it. Doubt is the
    probability of being infeasible, or its mean over the 3x3 neighbourhood where that is higher: infeasible cells lie
    together, a network errs cell by cell, and a foot covers more than one cell.

    probabilities: (..., 14, n, n), summing to 1 over the classes. Returns (..., n, n) cost in [0, 255].
    """
    classes = np.asarray(probabilities, dtype=np.float32)
    feasible, infeasible = classes[..., :COST_BINS, :, :], classes[..., INFEASIBLE_CLASS, :, :]
    weight = np.maximum(feasible.sum(axis=-3), np.finfo(np.float32).tiny)
    if_feasible = np.einsum("...cij,c->...ij", feasible, class_centres()) / weight
    doubt = np.maximum(infeasible, _neighbourhood_mean(infeasible))
    return np.asarray(if_feasible + doubt * (INFEASIBLE_COST - if_feasible), dtype=np.float32)


def _neighbourhood_mean(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """(..., n, n) mean over 3x3 cells, the border repeated beyond itself."""
    rows, columns = values.shape[-2:]
    padded = np.pad(values, [(0, 0)] * (values.ndim - 2) + [(1, 1), (1, 1)], mode="edge")
    across = padded[..., :rows, :] + padded[..., 1 : rows + 1, :] + padded[..., 2:, :]
    total = across[..., :columns] + across[..., 1 : columns + 1] + across[..., 2:]
    return np.asarray(total / np.float32(9))
