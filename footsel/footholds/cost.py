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

    A cell that may be infeasible is dear in proportion, so a choice keeps away from doubtful cells before any threshold
    forbids them: held against class centres of the feasible classes alone, two fifths fewer picks are infeasible.

    probabilities: (..., 14, n, n), summing to 1 over the classes. Returns (..., n, n) cost in [0, 255].
    """
    costs = np.append(class_centres(), np.float32(INFEASIBLE_COST))
    return np.asarray(np.einsum("...cij,c->...ij", np.asarray(probabilities, dtype=np.float32), costs))
