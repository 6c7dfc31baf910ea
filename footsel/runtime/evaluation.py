"""What a network's probabilities mean: class, cost, feasibility and confidence of every cell."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footsel.footholds.cost import COST_BINS, INFEASIBLE_CLASS, INFEASIBLE_COST, expected_cost


@dataclass(frozen=True, eq=False)
class CellEvaluation:
    """A network's judgement of every cell; all arrays are (40, 40), or (n, 40, 40) for n maps.

    class_: uint8, the most probable of the thirteen feasible classes, 13 where the cell is not feasible.
    cost: float32 mean cost over all classes (footholds.cost.expected_cost), 255 where the cell is not feasible.
    feasible: whether the cell is known and p(infeasible) is below the contract's `feasible_below`.
    confidence: float32, 1 - p(infeasible), how probably a foot may stand there; 0 where the height is unknown.
    """

    class_: NDArray[np.uint8]
    cost: NDArray[np.float32]
    feasible: NDArray[np.bool_]
    confidence: NDArray[np.float32]


def assemble(
    likeliest: NDArray[np.integer],
    infeasible: NDArray[np.float32],
    cost: NDArray[np.float32],
    known: NDArray[np.bool_],
    feasible_below: float,
) -> CellEvaluation:
    """A judgement of what a network answers; all arrays (n, 40, 40).

    likeliest: the most probable of the thirteen feasible classes. infeasible: p(infeasible).
    cost: mean cost over all classes.
    known: which cells have a height; no other cell is ever feasible.
    """
    feasible = known & (infeasible < feasible_below)
    return CellEvaluation(
        np.where(feasible, likeliest, INFEASIBLE_CLASS).astype(np.uint8),
        np.where(feasible, cost, np.float32(INFEASIBLE_COST)),
        feasible,
        confidence(infeasible, known),
    )


def confidence(infeasible: NDArray[np.float32], known: NDArray[np.bool_]) -> NDArray[np.float32]:
    """1 - p(infeasible) of known cells; what nobody has measured is trusted with nothing."""
    return np.asarray(np.where(known, np.float32(1) - infeasible, np.float32(0)), dtype=np.float32)


def decode(probabilities: NDArray[np.float32], known: NDArray[np.bool_], feasible_below: float) -> CellEvaluation:
    """The judgement that follows from (n, 14, 40, 40) probabilities; other arguments as in `assemble`."""
    likeliest = probabilities[:, :COST_BINS].argmax(axis=1)
    infeasible, cost = probabilities[:, INFEASIBLE_CLASS], expected_cost(probabilities)
    return assemble(likeliest, infeasible, cost, known, feasible_below)
