"""Figures of a checkpoint or an ONNX model on a dataset, by the same code for both."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from footsel.dataset import Samples, open_dataset
from footsel.errors import InputError, MissingExtraError, ModelError
from footsel.files import write_json
from footsel.footholds import LegLayout
from footsel.learning.degraded import Degradation, degraded
from footsel.learning.files import MODEL_FILE
from footsel.learning.predictions import CHUNK, Predict, predict_chunk
from footsel.learning.scores import Judgement
from footsel.legs import PAIRS, TRAINED_LEG
from footsel.runtime.network import Network


@dataclass(frozen=True, eq=False)
class EvaluatedModel:
    """A network of any origin, ready to be judged.

    name: how its figures are keyed. source: its file.
    """

    name: str
    source: Path
    pair: str
    robot: str
    layout: LegLayout
    feasible_below: float
    predict: Predict


def evaluate(
    predict: Predict,
    samples: Samples,
    layout: LegLayout,
    leg: str,
    feasible_below: float,
    degradation: Degradation | None = None,
) -> dict[str, Any]:
    """{"all": figures, "families": {name: figures}, "thresholds": curve}, as of footsel.learning.scores.Judgement.

    samples: maps of `leg`, the trained one. feasible_below: threshold on p(infeasible). degradation: of the input; what
    is found is judged by the labels of the maps as they are.
    """
    judgement = Judgement(layout, leg, feasible_below)
    with tqdm(total=len(samples), unit="map", desc="evaluating", disable=None) as bar:
        for start in range(0, len(samples), CHUNK):
            chunk = samples.take(slice(start, start + CHUNK))
            if degradation is not None:
                chunk = degraded(chunk, degradation, layout.resolution, first=start)
            judgement.update(predict_chunk(predict, chunk), chunk)
            bar.update(len(chunk))
    return judgement.result()


def evaluate_model(
    model: Path,
    dataset_dir: Path,
    out: Path | None = None,
    families: Sequence[str] | None = None,
    exclude: Sequence[str] | None = None,
    degradation: Degradation | None = None,
) -> dict[str, Any]:
    """Judge every network of `model` (a run, one pair of a run, an ONNX file or a model folder) on a whole dataset.

    out: JSON file for the figures, written all at once. degradation: of the input, as in `evaluate`.
    Raises ModelError for a model, InputError for a dataset that cannot be used or is of another robot.
    """
    dataset = open_dataset(dataset_dir)
    figures = {}
    for found in find_models(model):
        if found.pair not in dataset.pairs:
            continue
        robot = dataset.manifest["config"]["robot"]
        if found.robot != robot:
            raise InputError(
                f"{found.source} is for {found.robot}, the dataset for {robot}", "make a dataset of the same robot"
            )
        samples = dataset.load(found.pair, families=families, exclude=exclude)
        if not len(samples):
            raise InputError(f"{dataset_dir} has no maps of these families", "choose others; the manifest lists them")
        leg = TRAINED_LEG[found.pair]
        figures[found.name] = {
            "pair": found.pair,
            "feasible_below": found.feasible_below,
            **evaluate(found.predict, samples, found.layout, leg, found.feasible_below, degradation),
        }
    if not figures:
        raise InputError(f"{dataset_dir} has no maps for the legs of {model}", f"it has {', '.join(dataset.pairs)}")
    result = {
        "model": str(model),
        "dataset_sha256": dataset.sha256,
        "degradation": None if degradation is None else asdict(degradation),
        "networks": figures,
    }
    if out is not None:
        write_json(out, result)
    return result


def find_models(model: Path) -> list[EvaluatedModel]:
    """The networks at a path; raises ModelError if there is none."""
    if model.is_file() and model.suffix == ".onnx":
        return [_onnx(model)]
    runs = [folder for folder in (model, *(model / pair for pair in PAIRS)) if (folder / MODEL_FILE).is_file()]
    found = [_checkpoint(folder) for folder in runs] or [_onnx(path) for path in sorted(model.glob("*.onnx"))]
    if not found:
        raise ModelError(
            f"no trained network at {model}", "give a `footsel train` run, a model folder or an .onnx file"
        )
    return found


def _onnx(path: Path) -> EvaluatedModel:
    network = Network.load(path)
    contract = network.contract

    def predict(samples: Samples) -> np.ndarray[Any, np.dtype[np.float32]]:
        return network.probabilities(samples.heights(), samples.roll, samples.pitch)

    return EvaluatedModel(
        path.stem, path, contract.pair, contract.robot, contract.layout, contract.feasible_below, predict
    )


def _checkpoint(folder: Path) -> EvaluatedModel:
    try:
        from footsel.learning.batches import BatchEncoder
        from footsel.learning.checkpoint import load_network, network_predictor
    except ModuleNotFoundError as error:
        raise MissingExtraError("evaluating a checkpoint", "train", error.name or "torch") from None
    from footsel.footholds.encoding import InputEncoding

    net, info = load_network(folder)
    predict = network_predictor(net, BatchEncoder(InputEncoding.from_dict(info["encoding"])))
    layout = LegLayout.from_dict(info["layout"])
    return EvaluatedModel(info["pair"], folder, info["pair"], info["robot"], layout, info["feasible_below"], predict)
