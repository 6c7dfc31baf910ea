"""Judge networks for our pages, and keep the main figures in docs/results.

python docs/judge.py paper RUN UNSEEN        a run of the paper's recipe, on its own map and on families it never saw
python docs/judge.py held_out RUN DATASET    a run of `footsel train --exclude ...`, on those families and on the others
python docs/judge.py degraded MODEL DATASET  a network whose input is degraded, beside the oracle on the same input

docs/learning.md and docs/judging.md name the commands that make RUN, MODEL and the datasets, of seeds never trained on.
"""

import argparse
import csv
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from footsel.comparison.maps import built_in_courses
from footsel.comparison.poses import draw_poses
from footsel.dataset import Samples, open_dataset
from footsel.dataset.labelling import labelled
from footsel.errors import FootselError, InputError
from footsel.files import write_json
from footsel.footholds import Reason
from footsel.footholds.metrics import PickMetrics
from footsel.learning.checkpoint import load_network
from footsel.learning.degraded import Degradation, degraded
from footsel.learning.evaluate import EvaluatedModel, evaluate, evaluate_model, find_models
from footsel.learning.picks import final_cost_maps, nominal_distances, pick_cells
from footsel.legs import TRAINED_LEG
from footsel.oracle import Oracle
from footsel.terrain import LocalMap

RESULTS = Path(__file__).resolve().parent / "results"
#: What judging.md shows of degraded input.
DEGRADATIONS = {
    "none": Degradation(),
    "noise": Degradation("d435"),
    "holes": Degradation(holes=0.2),
    "both": Degradation("d435", 0.2),
}
#: Maps of each leg that the oracle labels again on degraded input.
ORACLE_MAPS = 2000
#: Base poses per built-in course that are drawn as `footsel compare` draws them, and the seed of both.
POSES, SEED = 300, 200


def main() -> int:
    """One study."""
    studies = {"paper": paper, "held_out": held_out, "degraded": degraded_input}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", choices=studies)
    parser.add_argument("model", metavar="MODEL", type=Path)
    parser.add_argument("dataset", metavar="DATASET", type=Path)
    args = parser.parse_args()
    try:
        write_json(RESULTS / f"{args.study}.json", studies[args.study](args.model, args.dataset))
    except FootselError as error:
        print(f"judge.py: error: {error}", file=sys.stderr)
        return 2
    return 0


def paper(run: Path, unseen: Path) -> dict[str, Any]:
    """Validation on the run's own map as it was measured while it was trained, and the figures on unseen families."""
    found = evaluate_model(run, unseen)
    networks = {}
    for pair, figures in found["networks"].items():
        _, info = load_network(run / pair)
        seen = set(open_dataset(unseen).manifest["families"]) - set(info["dataset"]["exclude"])
        if seen:
            raise InputError(f"{unseen} has families that were trained on: {', '.join(sorted(seen))}", "exclude them")
        with (run / pair / "curves.csv").open(newline="", encoding="utf-8") as file:
            curve = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        networks[pair] = {
            **_training(info),
            "curve": {key: [round(row[key], 5) for row in curve] for key in ("train_loss", "val_loss", "accuracy")},
            "validation": _main_figures(info["validation"]),
            "unseen": _main_figures(figures["all"]),
        }
    return {"unseen": _dataset(unseen), "networks": networks}


def held_out(run: Path, dataset: Path) -> dict[str, Any]:
    """Figures on the families that the run never saw, together and each, on all others, and as compare would ask."""
    networks = {}
    for model in find_models(run):
        _, info = load_network(run / model.pair)
        unseen = tuple(info["dataset"]["exclude"])
        if not unseen:
            raise InputError(f"{run} was trained on all families", "train with --exclude")
        new = evaluate_model(run / model.pair, dataset, families=unseen)["networks"][model.pair]
        old = evaluate_model(run / model.pair, dataset, exclude=unseen)["networks"][model.pair]
        asked = as_compared(model)
        asked = asked.take(np.flatnonzero(np.isin(asked.family, unseen)))
        leg = TRAINED_LEG[model.pair]
        compared = evaluate(model.predict, asked, model.layout, leg, model.feasible_below)
        networks[model.pair] = {
            **_training(info),
            "seen": _main_figures(old["all"]),
            "unseen": _main_figures(new["all"]),
            "unseen_as_compared": _main_figures(compared["all"]),
            "families": {name: _main_figures(figures) for name, figures in new["families"].items()},
        }
    return {"judged_on": _dataset(dataset), "as_compared": {"seed": SEED, "poses": POSES}, "networks": networks}


def degraded_input(model: Path, dataset: Path) -> dict[str, Any]:
    """Figures of each network and picks of the oracle for every degradation: on the dataset, and as compare asks."""
    found = find_models(model)
    drawn = {network.name: open_dataset(dataset).load(network.pair) for network in found}
    asked = {network.name: as_compared(network) for network in found}
    return {
        "judged_on": _dataset(dataset),
        **_degraded(found, drawn),
        "as_compared": {"seed": SEED, "poses": POSES, **_degraded(found, asked)},
    }


def _degraded(models: Sequence[EvaluatedModel], samples: Mapping[str, Samples]) -> dict[str, Any]:
    """networks and oracle: name of the network -> degradation -> figures."""
    networks: dict[str, Any] = {}
    oracle: dict[str, Any] = {}
    for found in models:
        maps, leg = samples[found.name], TRAINED_LEG[found.pair]
        for name, degradation in DEGRADATIONS.items():
            figures = evaluate(found.predict, maps, found.layout, leg, found.feasible_below, degradation)
            networks.setdefault(found.name, {})[name] = _main_figures(figures["all"])
            oracle.setdefault(found.name, {})[name] = _oracle_picks(maps.take(slice(ORACLE_MAPS)), found, degradation)
    return {"networks": networks, "oracle": {"maps": ORACLE_MAPS, **oracle}}


def as_compared(found: EvaluatedModel) -> Samples:
    """Maps of the trained leg at base poses that `footsel compare` would draw on built-in courses, labelled."""
    oracle, layout, leg = Oracle.load(found.robot), found.layout, TRAINED_LEG[found.pair]
    rows, families = [], []
    for index, course in enumerate(built_in_courses(SEED)):
        for pose in draw_poses(np.random.default_rng([SEED, index]), course.elevation_map, layout, POSES):
            rows.append(labelled(oracle, layout.local_map(course.elevation_map, pose, leg), leg, pose))
            families.append(course.name)
    fields = map(np.stack, zip(*rows, strict=True))
    return Samples(*fields, family=np.array(families), course=np.full(len(rows), SEED))


def _oracle_picks(samples: Samples, found: EvaluatedModel, degradation: Degradation) -> dict[str, Any]:
    """What the oracle picks if it believes the degraded map, judged by the true one."""
    oracle, layout, leg = Oracle.load(found.robot), found.layout, TRAINED_LEG[found.pair]
    seen = degraded(samples, degradation, layout.resolution)
    labels = [
        oracle.label(LocalMap(heights, layout.resolution, np.zeros(3), 0.0), leg, float(roll), float(pitch))
        for heights, roll, pitch in zip(seen.heights(), samples.roll, samples.pitch, strict=True)
    ]
    distances = nominal_distances(layout, leg, samples.roll, samples.pitch)
    cost, feasible = np.stack([label.cost for label in labels]), np.stack([label.feasible for label in labels])
    picks = PickMetrics()
    chosen = pick_cells(final_cost_maps(cost, feasible, distances), distances)
    picks.update(chosen, final_cost_maps(seen.cost, np.equal(seen.reason, Reason.FEASIBLE), distances), seen.reason)
    return picks.result()


def _training(info: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "recipe": info["recipe"]["name"],
        "maps": info["maps"]["training"],
        "epochs": info["epochs_done"],
        "exclude": info["dataset"]["exclude"],
    }


def _main_figures(figures: Mapping[str, Any]) -> dict[str, Any]:
    return {key: figures[key] for key in ("maps", "cells_likeliest", "cells", "picks")}


def _dataset(folder: Path) -> dict[str, Any]:
    dataset = open_dataset(folder)
    keys: Sequence[str] = ("maps", "seed", "recipe", "families")
    return {**{key: dataset.manifest["config"][key] for key in keys}, "sha256": dataset.sha256}


if __name__ == "__main__":
    sys.exit(main())
