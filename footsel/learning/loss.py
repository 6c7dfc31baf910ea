"""The paper's loss: cross-entropy over all cells, weighted by how rare a class is (section III-B)."""

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.cost import CLASSES, cost_to_class

#: c of the class weights, "In this application we used c=1.08".
CLASS_WEIGHT_C = 1.08

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
