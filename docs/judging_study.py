"""What judging.md says of temperature and thresholds: python docs/judging_study.py MODEL DATASET

Each half of the dataset's courses is judged with the temperature and the threshold chosen on the other half.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize_scalar

from footsel.dataset import open_dataset
from footsel.footholds import Reason
from footsel.footholds.cost import INFEASIBLE_CLASS, softmax
from footsel.learning.evaluate import EvaluatedModel, find_models
from footsel.learning.loss import LABEL_CLASS
from footsel.learning.predictions import CHUNK, predict_all
from footsel.learning.reliability import Reliability
from footsel.learning.threshold import choose_feasible_below, threshold_curve
from footsel.legs import TRAINED_LEG

SPLITS = 20
#: Cells that a temperature is fitted to; more do not change its third digit.
FITTED = 200_000


def halves(courses: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Masks of the maps on one half of the courses and on the other; maps of a course are much alike."""
    known = np.unique(courses)
    first = np.isin(courses, np.random.default_rng(seed).choice(known, len(known) // 2, replace=False))
    return first, ~first


def temperature(logits: np.ndarray, labels: np.ndarray) -> float:
    """The divisor of the logits (cells, 14) that makes the labels most probable."""

    def surprise(log_divisor: float) -> float:
        probabilities = softmax(logits / np.exp(log_divisor), axis=1)
        return -float(np.log(np.take_along_axis(probabilities, labels[:, None], axis=1)).mean())

    return float(np.exp(minimize_scalar(surprise, bounds=(-1, 1), method="bounded").x))


def study_temperature(found: EvaluatedModel, dataset_dir: Path) -> None:
    """Calibration errors without and with a temperature."""
    samples = open_dataset(dataset_dir).load(found.pair)
    chunks = (samples.take(slice(start, start + CHUNK)) for start in range(0, len(samples), CHUNK))
    # Logits up to a constant per cell, which no softmax sees.
    logits = np.log(np.maximum(np.concatenate([found.predict(chunk) for chunk in chunks]), 1e-30))
    known, labels = samples.reason != Reason.UNKNOWN, LABEL_CLASS[samples.cost].astype(np.intp)
    for fit_on, judge_on in (split := halves(samples.course, 0), split[::-1]):
        cells, truth = np.moveaxis(logits[fit_on], 1, -1)[known[fit_on]], labels[fit_on][known[fit_on]]
        some = np.random.default_rng(0).choice(len(truth), min(FITTED, len(truth)), replace=False)
        fitted = temperature(cells[some], truth[some])
        cells, truth = np.moveaxis(logits[judge_on], 1, -1)[known[judge_on]], labels[judge_on][known[judge_on]]
        for divisor in (1.0, fitted):
            probabilities = softmax(cells / divisor, axis=1)
            likeliest, infeasible = Reliability(), Reliability()
            likeliest.update(probabilities.max(axis=1), probabilities.argmax(axis=1) == truth)
            infeasible.update(probabilities[:, INFEASIBLE_CLASS], truth == INFEASIBLE_CLASS)
            errors = [each.result()["ece"] for each in (likeliest, infeasible)]
            sure = probabilities[:, INFEASIBLE_CLASS] < 1e-3
            print(
                f"{found.name}: temperature {divisor:.3f}: calibration error of the most probable class "
                f"{errors[0]:.2%}, of p(infeasible) {errors[1]:.2%}; of cells with p(infeasible) < 0.1 %, "
                f"{(truth[sure] == INFEASIBLE_CLASS).mean():.2%} are infeasible"
            )


def study_threshold(found: EvaluatedModel, dataset_dir: Path) -> None:
    """What the rule's threshold does on maps that it was not chosen on."""
    samples = open_dataset(dataset_dir).load(found.pair)
    predictions = predict_all(found.predict, samples)
    leg = TRAINED_LEG[found.pair]
    splits = [halves(samples.course, seed) for seed in range(SPLITS)]
    curves = [
        [threshold_curve(predictions.take(half), samples.take(half), found.layout, leg) for half in split]
        for split in splits
    ]
    figures = []
    for chosen_on, judged_on in [*curves, *(pair[::-1] for pair in curves)]:
        chosen = choose_feasible_below(chosen_on)
        point = next(each for each in judged_on if each["feasible_below"] == chosen)
        figures.append((chosen, point["infeasible_rate"], point["missed_rate"], point["regret_mean"]))
    chosen, infeasible, missed, regret = np.array(figures).T
    print(
        f"{found.name}: p(infeasible) < {np.median(chosen):.3f} ({chosen.min():.3f} to {chosen.max():.3f}); on the "
        f"other half infeasible picks {infeasible.mean():.2%}, missed {missed.mean():.2%}, regret {regret.mean():.2f}"
    )


if __name__ == "__main__":
    model, dataset_dir = map(Path, sys.argv[1:])
    for found in find_models(model):
        if found.pair in open_dataset(dataset_dir).pairs:
            study_temperature(found, dataset_dir)
            study_threshold(found, dataset_dir)
