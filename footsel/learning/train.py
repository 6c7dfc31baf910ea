"""Training of one pair's network, top to bottom: what is asked, data, model, loop."""

import csv
import io
import json
import math
import platform
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from tqdm import tqdm

import footsel
from footsel.claim import claim_folder
from footsel.dataset import Samples, open_dataset
from footsel.errors import InputError
from footsel.files import replace_file, write_json
from footsel.footholds import LegLayout
from footsel.learning.augmentation import as_seen
from footsel.learning.ball_choice import with_best_balls
from footsel.learning.ball_fit import with_fitted_balls
from footsel.learning.batches import shuffled_batches
from footsel.learning.checkpoint import (
    Progress,
    load_checkpoint,
    load_network,
    network_predictor,
    save_checkpoint,
    save_model,
)
from footsel.learning.files import CHECKPOINT_FILE, SKELETON_FILE
from footsel.learning.learner import Learner, computes_in_bfloat16
from footsel.learning.loss import class_shares, class_weights
from footsel.learning.predictions import predict_all
from footsel.learning.ranks import ALONE, Ranks
from footsel.learning.recipe import Recipe
from footsel.learning.schedule import learning_rate as rate_of
from footsel.learning.scores import Judgement
from footsel.learning.skeleton import LegSkeleton
from footsel.learning.threshold import choose_feasible_below, threshold_curve, usual
from footsel.learning.warm_start import lineage, skeleton_of, start_from
from footsel.legs import TRAINED_LEG
from footsel.robot import load_robot

#: A killed training loses at most this much. [s]
CHECKPOINT_SECONDS = 120.0


@dataclass(frozen=True, eq=False)
class TrainingData:
    """Labelled maps of the trained leg of one pair, and what is known of them.

    robot, layout, skeleton: whose legs. dataset: configuration it was made with, as in its manifest, families left out
    since then added to `exclude`; dataset_sha256: of the manifest.
    """

    pair: str
    training: Samples
    validation: Samples
    robot: str
    layout: LegLayout
    skeleton: LegSkeleton
    dataset: Mapping[str, Any]
    dataset_sha256: str


def train(
    dataset_dir: Path,
    out: Path,
    pair: str,
    recipe: Recipe,
    resume: bool = False,
    epochs: int | None = None,
    seed: int = 0,
    threads: int = 1,
    learning_rate: float | None = None,
    start: str | Path | None = None,
    exclude: Sequence[str] = (),
    bar_line: int | None = None,
    ranks: Ranks = ALONE,
) -> dict[str, Any]:
    """Train the network of `pair` on a dataset of `footsel dataset`; files go to `out`/`pair`.

    resume: continue a training that was interrupted, to the same result.
    epochs, learning_rate: instead of the recipe's.
    start: run, released model or file of weights to begin with (footsel.learning.warm_start); the card names it.
    threads: of torch; two pairs side by side on one thread each take less time than one after the other on two.
    exclude: terrain families to learn nothing from, so that the network can be judged on what it never saw.
    bar_line: line of the terminal for the progress bar, where several trainings share it.
    ranks: processes that train this network together, each calling this function; the first one writes the files.
    Returns the header of the final model (footsel.learning.checkpoint.load_network).
    """
    data = load_data(dataset_dir, pair, exclude)
    recipe = replace(recipe, epochs=epochs or recipe.epochs, learning_rate=learning_rate or recipe.learning_rate)
    torch.set_num_threads(threads)
    return fit(data, out / pair, recipe, resume, seed, start=start, bar_line=bar_line, ranks=ranks)


def load_data(dataset_dir: Path, pair: str, exclude: Sequence[str] = ()) -> TrainingData:
    """The maps of one pair of a dataset of `footsel dataset`, all in memory, but for the families to `exclude`."""
    dataset = open_dataset(dataset_dir)
    training, validation = dataset.split(pair, exclude=exclude)
    made_with = dict(dataset.manifest["config"])
    if exclude:
        made_with["exclude"] = sorted({*made_with["exclude"], *exclude})
    robot = load_robot(str(made_with["robot"]))
    skeleton = LegSkeleton.of(robot, TRAINED_LEG[pair])
    return TrainingData(pair, training, validation, robot.name, robot.layout, skeleton, made_with, dataset.sha256)


def fit(
    data: TrainingData,
    folder: Path,
    recipe: Recipe,
    resume: bool = False,
    seed: int = 0,
    checkpoint_seconds: float = CHECKPOINT_SECONDS,
    start: str | Path | None = None,
    bar_line: int | None = None,
    ranks: Ranks = ALONE,
) -> dict[str, Any]:
    """Train on maps in memory; `folder` gets config.json, curves.csv, validation.json, the checkpoint and the model."""
    # What is asked. A folder holds one training, from its first update to its last.
    config = {
        "robot": data.robot,
        "pair": data.pair,
        "recipe": recipe.to_dict(),
        "dataset": dict(data.dataset),
        "dataset_sha256": data.dataset_sha256,
        "maps": {"training": len(data.training), "validation": len(data.validation)},
        "seed": seed,
        "started_from": None if start is None else lineage(start, data.pair),
    }
    resumed = _claim_folder(folder, config, resume, ranks)

    # Data.
    encoding = recipe.encoding(data.layout.height_range)
    shares = class_shares(data.training.cost)
    weights = class_weights(shares, recipe.class_weights)
    batches_per_epoch = -(-len(data.training) // recipe.batch_size)

    # Model.
    skeleton = _skeleton(data, recipe, folder, start, ranks)
    learner = Learner(recipe, data.layout, weights, seed, ranks, skeleton)
    progress = load_checkpoint(folder, learner) if resumed else Progress()
    if start is not None and not resumed:
        start_from(learner, start, data.pair)
    rows = _read_curves(folder / "curves.csv")[: progress.epoch]

    # Loop.
    silent = None if ranks.first else True  # None: where there is no terminal.
    bar = tqdm(
        total=recipe.epochs * len(data.training),
        unit="map",
        desc=data.pair,
        smoothing=0.05,
        disable=silent,
        position=bar_line,
    )
    bar.update(progress.epoch * len(data.training) + progress.maps)
    saved = time.monotonic()
    for epoch in range(progress.epoch, recipe.epochs):
        started = time.monotonic() - progress.seconds
        batches = shuffled_batches(len(data.training), recipe.batch_size, seed, epoch)
        for batch in range(progress.batch, batches_per_epoch):
            samples = data.training.take(batches[batch])
            if recipe.noise + recipe.holes + recipe.shift > 0:
                samples = as_seen(
                    samples,
                    data.layout.resolution,
                    recipe.noise,
                    recipe.holes,
                    recipe.shift,
                    seed=(seed, epoch, batch),
                )
            rate = rate_of(recipe, epoch, batch, batches_per_epoch)
            loss = learner.update(samples, rate, updates_before=epoch * batches_per_epoch + batch)
            if not math.isfinite(loss):
                raise InputError(f"the loss became {loss} in epoch {epoch}", "lower the recipe's learning_rate")
            progress.add(loss, len(samples), time.monotonic() - started)
            bar.update(len(samples))
            bar.set_postfix(epoch=epoch, loss=f"{progress.mean_loss:.4f}", refresh=False)
            if ranks.first and time.monotonic() - saved >= checkpoint_seconds:
                save_checkpoint(folder, learner, progress)
                saved = time.monotonic()

        # After every epoch the model is usable, and judged on maps that it never learns from. One process does that,
        # the others wait for it in their next update.
        learnt, progress = progress, Progress(epoch=epoch + 1)
        if not ranks.first:
            continue
        judgement, validation_loss = _validate(learner, data, np.ones_like(weights) if recipe.calibrated else weights)
        # The rate of the epoch's last update, which a resumed training may have made before it was killed.
        rate = rate_of(recipe, epoch, batches_per_epoch - 1, batches_per_epoch)
        measured = {"lr": rate, "train_loss": learnt.mean_loss, "val_loss": validation_loss}
        seconds = round(time.monotonic() - started, 1)
        rows.append({"epoch": epoch, **measured, **_curve_figures(judgement), "seconds": seconds})
        info = {
            **config,
            "layout": data.layout.to_dict(),
            "skeleton": skeleton.to_dict(),
            "encoding": encoding.to_dict(),
            "in_channels": learner.net.in_channels,
            "classes": learner.net.classes,
            "class_shares": shares.tolist(),
            "epochs_done": epoch + 1,
            "feasible_below": judgement["feasible_below"],
            "validation": judgement["metrics"],
            "version": footsel.__version__,
        }
        save_model(folder, learner.weights(), info)
        write_json(folder / "validation.json", {"epoch": epoch, **judgement})
        _write_curves(folder / "curves.csv", rows)
        # Last, so that a training killed anywhere above does the epoch's end again instead of leaving it out.
        save_checkpoint(folder, learner, progress)
        saved = time.monotonic()
        figures = "  ".join(f"{column} {_short(value)}" for column, value in rows[-1].items())
        bar.write(f"{data.pair}: {figures}", file=sys.stderr)
    bar.close()
    ranks.wait()
    return load_network(folder)[1]


def _skeleton(data: TrainingData, recipe: Recipe, folder: Path, start: str | Path | None, ranks: Ranks) -> LegSkeleton:
    """Of the network to be trained: what the folder holds, or what the weights to begin with had, or a new one.

    The first process makes it: what is fitted may differ in the last bit from machine to machine.
    """
    path = folder / SKELETON_FILE
    if ranks.first and not path.is_file():
        chosen = skeleton_of(start, data.pair) or data.skeleton
        if chosen.hip is None:
            chosen = replace(chosen, hip=data.skeleton.hip)
        hip = "hip" in recipe.features
        chosen = with_best_balls(chosen, data.training, data.layout, recipe.balls, hip)
        if recipe.fit_balls and chosen.rises is None:
            chosen = with_fitted_balls(chosen, data.training, data.layout, silent=False)
        write_json(path, chosen.to_dict())
    ranks.wait()
    return LegSkeleton.from_dict(json.loads(path.read_text(encoding="utf-8")))


def _validate(learner: Learner, data: TrainingData, class_weight: NDArray[np.float32]) -> tuple[dict[str, Any], float]:
    """The threshold with its curve and the figures at it, and the validation loss."""
    predictions = predict_all(network_predictor(learner.usable_network(), learner.encode), data.validation)
    leg = TRAINED_LEG[data.pair]
    level = usual(data.validation)
    curve = threshold_curve(predictions.take(level), data.validation.take(level), data.layout, leg)
    feasible_below = choose_feasible_below(curve)
    judgement = Judgement(data.layout, leg, feasible_below)
    judgement.update(predictions, data.validation)
    found = judgement.result()
    metrics = {**found.pop("all"), **found}
    return {"feasible_below": feasible_below, "metrics": metrics}, predictions.cross_entropy(
        data.validation, class_weight
    )


def _curve_figures(judgement: Mapping[str, Any]) -> dict[str, Any]:
    """Accuracy as the paper measures it, by the most probable class; what is safe by the threshold that is used."""
    likeliest, cells, picks = (judgement["metrics"][key] for key in ("cells_likeliest", "cells", "picks"))
    return {
        "accuracy": likeliest["accuracy"],
        "accuracy_feasible": likeliest["accuracy_feasible"],
        "miou_present": likeliest["miou_present"],
        "feasible_below": judgement["feasible_below"],
        "false_safe": cells["false_safe_rate"],
        "false_unsafe": cells["false_unsafe_rate"],
        "infeasible_rate": picks["infeasible_rate"],
        "missed_rate": picks["missed_rate"],
        "regret_mean": picks["regret_mean"],
    }


def _claim_folder(folder: Path, config: dict[str, Any], resume: bool, ranks: Ranks) -> bool:
    """Take a new folder, or one whose training is the one asked for; returns whether there is something to go on from.

    Raises InputError if the folder holds another training, or any without `resume`.
    """
    started = (folder / CHECKPOINT_FILE).is_file()
    if not ranks.first:
        ranks.wait()
        return started
    if started and not resume:
        raise InputError(f"{folder} already holds a training", "give --resume to go on with it, or another folder")
    versions = {"footsel": footsel.__version__, "torch": torch.__version__, "python": platform.python_version()}
    bfloat16 = computes_in_bfloat16(config["recipe"]["precision"])
    machine = {"threads": torch.get_num_threads(), "bfloat16": bfloat16, "versions": versions}
    claim_folder(folder, "training", config, notes=machine)
    ranks.wait()
    return started


def _read_curves(path: Path) -> list[dict[str, Any]]:
    if not path.is_file():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _write_curves(path: Path, rows: list[dict[str, Any]]) -> None:
    text = io.StringIO()
    # A resumed training may be of an older version, whose rows had fewer columns.
    writer = csv.DictWriter(text, list(rows[-1]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    replace_file(path, lambda temporary: temporary.write_text(text.getvalue(), encoding="utf-8"))


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
