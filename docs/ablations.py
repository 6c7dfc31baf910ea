"""Train the rows of ablations.toml, judge them, and write docs/results/ablations.json.

python docs/ablations.py DATA TEST WORK [--data NAME=FOLDER ...] [--rows NAME ...]

DATA and TEST are datasets of different seeds, FOLDER is one for the rows that name it:
footsel dataset DATA --legs front --maps 102000 --seed 0
footsel dataset FOLDER --legs front --maps 51000 --seed 0 --recipe four_headings
footsel dataset TEST --maps 4000 --seed 5
WORK keeps what is trained: killed, the same command goes on. Rows may be shared out among several commands.
"""

import argparse
import csv
import json
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import torch

import footsel
from footsel.benchmark.machine import cpu_name
from footsel.dataset import Dataset, open_dataset
from footsel.errors import FootselError, InputError, UnknownNameError
from footsel.files import write_json
from footsel.learning.checkpoint import load_network
from footsel.learning.evaluate import evaluate, find_models
from footsel.learning.files import MODEL_FILE
from footsel.learning.learner import computes_in_bfloat16
from footsel.learning.recipe import Recipe
from footsel.learning.threshold import at_missed
from footsel.learning.train import TrainingData, fit, load_data
from footsel.legs import TRAINED_LEG
from footsel.runtime.model_folder import checksum

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

DOCS = Path(__file__).resolve().parent
RESULT = DOCS / "results" / "ablations.json"
#: Where networks are compared: a threshold of its own for each, so that equally many footholds are missed.
MISSED = (0.01, 0.02, 0.05)
#: What is kept of every point of a threshold curve.
CURVE = ("feasible_below", "infeasible_rate", "missed_rate", "regret_mean", "false_safe_rate", "false_unsafe_rate")


def main() -> int:
    """Rows one after the other, the result rewritten after each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("data", "test", "work"):
        parser.add_argument(name, metavar=name.upper(), type=Path)
    parser.add_argument(
        "--data", nargs="+", default=(), dest="others", metavar="NAME=FOLDER", help="dataset of rows that name it"
    )
    parser.add_argument("--rows", nargs="+", metavar="NAME", help="these alone (default: all of ablations.toml)")
    args = parser.parse_args()
    plan = tomllib.loads((DOCS / "ablations.toml").read_text(encoding="utf-8"))
    try:
        if wrong := [other for other in args.others if "=" not in other]:
            raise InputError(f"--data {wrong[0]} names no folder", "give NAME=FOLDER")
        folders = {"": args.data, **dict(other.split("=", 1) for other in args.others)}
        run(plan, folders, args.test, args.work, args.rows or list(plan["rows"]))
    except FootselError as error:
        print(f"ablations.py: error: {error}", file=sys.stderr)
        return 2
    return 0


def run(
    plan: Mapping[str, Any], folders: Mapping[str, str | Path], test_dir: Path, work: Path, names: list[str]
) -> None:
    """Train and judge the rows of these names; what is done already is not done again.

    folders: of the datasets, "" for that of the rows that name none.
    """
    rows = {name: Row.of(plan, name, work) for name in plan["rows"]}
    if unknown := [name for name in names if name not in rows]:
        raise UnknownNameError("row", unknown[0], list(rows))
    torch.set_num_threads(1)
    test = open_dataset(test_dir)
    datasets = {name: load_data(Path(folder), plan["legs"]) for name, folder in folders.items()}
    if missing := [rows[name].data for name in names if rows[name].data not in datasets]:
        raise InputError(f"no dataset {missing[0]}", f"give its folder: --data {missing[0]}=FOLDER")
    if any(test.manifest["config"]["seed"] == data.dataset["seed"] for data in datasets.values()):
        raise InputError(f"{test_dir} is of the seed that is trained on", "judge on a dataset of another seed")
    for number, name in enumerate(names, start=1):
        print(f"row {number} of {len(names)}: {name}", file=sys.stderr)
        rows[name].train(datasets[rows[name].data])
        rows[name].judge(test, plan["legs"])
        done = [row.result() for row in rows.values() if row.data in datasets and row.is_done(datasets[row.data], test)]
        write_json(RESULT, {**conditions(plan, datasets[""], test), "rows": done})


@dataclass(frozen=True)
class Row:
    """One training.

    changes: what the plan says of it. maps: how many it learns from. data: name of the dataset that they are of.
    seed: of everything that is random. folder: where it is kept.
    """

    name: str
    changes: Mapping[str, Any]
    recipe: Recipe
    maps: int
    data: str
    seed: int
    folder: Path

    @classmethod
    def of(cls, plan: Mapping[str, Any], name: str, work: Path) -> "Row":
        """The row `name` of the plan."""
        changes = plan["rows"][name]
        values = {**Recipe.load(plan["recipe"]).to_dict(), **plan["base"], **changes}
        maps, data, seed = values.pop("maps"), values.pop("data", ""), values.pop("seed", 0)
        folder = work / re.sub(r"\W+", "_", name).strip("_")
        return cls(name, changes, Recipe.from_dict(values), maps, data, seed, folder)

    def train(self, data: TrainingData) -> None:
        """Train to the end; a training that was interrupted goes on."""
        if self.maps > len(data.training):
            raise InputError(
                f"row {self.name} needs {self.maps} training maps, there are {len(data.training)}",
                "make a larger dataset",
            )
        first = data.training.take(slice(self.maps))
        fit(replace(data, training=first), self.folder, self.recipe, resume=True, seed=self.seed)

    def judge(self, test: Dataset, pair: str) -> None:
        """Write figures.json, unless this model has been judged on this dataset."""
        if self._figures_on(test) is None:
            (model,) = find_models(self.folder)
            found = evaluate(model.predict, test.load(pair), model.layout, TRAINED_LEG[pair], model.feasible_below)
            write_json(self._figures, {**self._judged(test), **found["all"], "thresholds": found["thresholds"]})

    def is_done(self, data: TrainingData, test: Dataset) -> bool:
        """Whether the folder holds this very row, trained on this data and judged on this dataset."""
        if self._figures_on(test) is None:
            return False
        info = load_network(self.folder)[1]
        # A recipe of before may lack values that came later.
        made = (Recipe.from_dict(info["recipe"]), info["maps"]["training"], info["epochs_done"])
        return info["dataset_sha256"] == data.dataset_sha256 and made == (self.recipe, self.maps, self.recipe.epochs)

    def result(self) -> dict[str, Any]:
        """What docs/results keeps of it."""
        figures = read(self._figures)
        net, _ = load_network(self.folder)
        with (self.folder / "curves.csv").open(newline="", encoding="utf-8") as file:
            seconds = sum(float(epoch["seconds"]) for epoch in csv.DictReader(file))
        curve = figures["thresholds"]
        return {
            "name": self.name,
            "changes": dict(self.changes),
            "maps": self.maps,
            "epochs": self.recipe.epochs,
            "minutes": round(seconds / 60, 1),
            "parameters": sum(parameter.numel() for parameter in net.parameters()),
            **{key: figures[key] for key in ("cells_likeliest", "cells", "picks")},
            "at_missed": {str(share): at_missed(curve, share) for share in MISSED},
            "thresholds": {key: [round_off(point[key]) for point in curve] for key in CURVE},
        }

    @property
    def _figures(self) -> Path:
        return self.folder / "figures.json"

    def _judged(self, test: Dataset) -> dict[str, str]:
        return {"model_sha256": checksum((self.folder / MODEL_FILE).read_bytes()), "test_sha256": test.sha256}

    def _figures_on(self, test: Dataset) -> Any:
        """The figures of this model on this dataset, None if there are none yet."""
        if not self._figures.is_file():
            return None
        found = read(self._figures)
        return found if all(found[key] == value for key, value in self._judged(test).items()) else None


def conditions(plan: Mapping[str, Any], data: TrainingData, test: Dataset) -> dict[str, Any]:
    """What all rows have in common."""
    return {
        "recipe": plan["recipe"],
        "legs": plan["legs"],
        "base": plan["base"],
        "training": {"config": dict(data.dataset), "sha256": data.dataset_sha256},
        "test": {"config": test.manifest["config"], "sha256": test.sha256},
        "cpu": cpu_name(),
        "threads": 1,
        "bfloat16": computes_in_bfloat16(Recipe.load(plan["recipe"]).precision),
        "versions": {"footsel": footsel.__version__, "torch": torch.__version__},
    }


def read(path: Path) -> Any:
    """A JSON file."""
    return json.loads(path.read_text(encoding="utf-8"))


def round_off(value: float | None) -> float | None:
    """Six digits are more than 4000 maps can tell."""
    return None if value is None else round(value, 6)


if __name__ == "__main__":
    sys.exit(main())
