"""What a network says of every cell of labelled maps, kept small enough to be judged at many thresholds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.dataset.samples import UNKNOWN_HEIGHT, Samples
from footsel.footholds.cost import COST_BINS, INFEASIBLE_CLASS, INFEASIBLE_COST, expected_cost
from footsel.learning.loss import LABEL_CLASS
from footsel.runtime.evaluation import CellEvaluation, confidence

#: Samples to (n, 14, 40, 40) class probabilities: a checkpoint, an ONNX model or anything else.
Predict = Callable[[Samples], NDArray[np.float32]]

#: Maps per call of a predictor: large enough to keep it busy, small enough for its memory.
CHUNK = 256


@dataclass(frozen=True, eq=False)
class Predictions:
    """A network's output for n maps, reduced to what is judged; all arrays are (n, 40, 40).

    class_: uint8 the most probable of the thirteen feasible classes. likeliest: uint8 of all fourteen; likelihood:
    float32 its probability. cost: float32 mean cost over all classes. infeasible: float32 p(infeasible).
    label_probability: float32 probability given to the label's class. known: which cells have a height.
    """

    class_: NDArray[np.uint8]
    likeliest: NDArray[np.uint8]
    likelihood: NDArray[np.float32]
    cost: NDArray[np.float32]
    infeasible: NDArray[np.float32]
    label_probability: NDArray[np.float32]
    known: NDArray[np.bool_]

    def take(self, index: ArrayLike | slice) -> "Predictions":
        """Those of the maps at `index` (slice, mask or integers)."""
        return Predictions(**{field.name: getattr(self, field.name)[index] for field in fields(self)})

    @classmethod
    def concatenate(cls, parts: Sequence["Predictions"]) -> "Predictions":
        """All of `parts`, in order."""
        return cls(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(cls)})

    def feasible(self, feasible_below: float) -> NDArray[np.bool_]:
        """Which cells the runtime would call feasible at this threshold."""
        return self.known & (self.infeasible < feasible_below)

    def decode(self, feasible_below: float) -> CellEvaluation:
        """What the runtime makes of the same probabilities (footsel.runtime.evaluation.decode)."""
        feasible = self.feasible(feasible_below)
        return CellEvaluation(
            np.where(feasible, self.class_, np.uint8(INFEASIBLE_CLASS)),
            np.where(feasible, self.cost, np.float32(INFEASIBLE_COST)),
            feasible,
            confidence(self.infeasible, self.known),
        )

    def cross_entropy(self, samples: Samples, weights: NDArray[np.float32]) -> float:
        """The training's loss, weighted by class, over the maps as one batch."""
        cell_weights = weights[LABEL_CLASS[samples.cost]]
        surprise = -np.log(np.maximum(self.label_probability, np.finfo(np.float32).tiny))
        return float(np.sum(cell_weights * surprise, dtype=np.float64) / np.sum(cell_weights, dtype=np.float64))


def predict_chunk(predict: Predict, samples: Samples) -> Predictions:
    """One call of the predictor."""
    probabilities = predict(samples)
    labels = LABEL_CLASS[samples.cost][:, None]
    return Predictions(
        class_=probabilities[:, :COST_BINS].argmax(axis=1).astype(np.uint8),
        likeliest=probabilities.argmax(axis=1).astype(np.uint8),
        likelihood=probabilities.max(axis=1),
        cost=expected_cost(probabilities),
        infeasible=probabilities[:, INFEASIBLE_CLASS].copy(),
        label_probability=np.take_along_axis(probabilities, labels, axis=1)[:, 0],
        known=samples.heights_tenth_mm != UNKNOWN_HEIGHT,
    )


def predict_all(predict: Predict, samples: Samples) -> Predictions:
    """All maps, a chunk at a time."""
    starts = range(0, len(samples), CHUNK)
    return Predictions.concatenate([predict_chunk(predict, samples.take(slice(s, s + CHUNK))) for s in starts])
