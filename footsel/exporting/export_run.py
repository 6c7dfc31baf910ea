"""`footsel export`: the two networks of a training run, or of a release, become a released model folder."""

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from footsel.errors import InputError, MissingExtraError
from footsel.footholds import DISTANCE_WEIGHT, LegLayout
from footsel.footholds.encoding import InputEncoding
from footsel.legs import PAIRS, TRAINED_LEG
from footsel.runtime.contract import FRAME, ModelContract
from footsel.runtime.model_folder import (
    PARITY_FILE,
    SUMS_FILE,
    VARIANTS,
    available_models,
    find_model_folder,
    load_networks,
    network_file,
    sums_text,
)

try:
    from tqdm import tqdm

    from footsel.exporting.decoding import with_decoding
    from footsel.exporting.engines import double_precision
    from footsel.exporting.onnx_file import OPSET, with_contract
    from footsel.exporting.parity import Parity
    from footsel.exporting.quantise import quantised
    from footsel.exporting.sources import Source, open_source
    from footsel.exporting.trial_maps import trial_maps
    from footsel.learning.files import weights_file
except ImportError as error:
    raise MissingExtraError("exporting a model", "train", error.name or "torch") from None

from footsel.exporting.model_card import model_card
from footsel.exporting.provenance import source_commit

#: Maps on which torch and the exported file are compared, and maps that set the ranges of the 8-bit variant.
PARITY_MAPS, CALIBRATION_MAPS = 10_000, 300
_PARITY_SEED, _CALIBRATION_SEED = 1, 2
#: Maps that torch gets at a time.
_BATCH = 50


@dataclass(frozen=True)
class ExportedPair:
    """The files of one pair of legs, and how far each is from the network that was trained.

    files: name -> content. parity: variant -> JSON values of its report.
    """

    files: Mapping[str, bytes]
    parity: Mapping[str, Mapping[str, Any]]


def export_run(
    run: str | Path, out: str | Path, int8: bool = False, parity_maps: int = PARITY_MAPS, weights: bool = True
) -> Path:
    """Write the model folder `out` from `front` and `hind` networks and return its path.

    run: folder of `footsel train`; or a model folder or the name of one, exported again with this version's contract.
    int8: add a quantised variant of each network.
    parity_maps: number of maps on which every file is compared with the trained network.
    weights: also keep what a training can go on from.

    Nothing is written if a network is missing, or if a float32 file says another class than its network. Files that
    `out` held before are replaced.
    """
    run = find_model_folder(run) if str(run) in available_models() and not Path(run).exists() else Path(run)
    out = Path(out)
    if out.exists() and not out.is_dir():
        raise InputError(f"{out} is a file", "give a folder to write the model to")
    sources = {pair: open_source(run, pair) for pair in PAIRS}
    pairs = {}
    for pair in PAIRS:
        pairs[pair] = export_network(sources[pair], int8, parity_maps)
    infos = {pair: source.info for pair, source in sources.items()}
    parity = {pair: exported.parity for pair, exported in pairs.items()}
    metrics = {pair: info["validation"] for pair, info in infos.items()}
    networks = {name: content for exported in pairs.values() for name, content in exported.files.items()}
    if weights:
        networks.update({weights_file(pair): source.weights for pair, source in sources.items()})
    texts = {
        "metrics.json": _json({"robot": infos["front"]["robot"], **metrics}),
        PARITY_FILE: _json(parity),
        "model_card.md": model_card(infos, parity, {name: len(content) for name, content in networks.items()}),
    }
    _write_folder(out, {**networks, **{name: text.encode() for name, text in texts.items()}})
    return out


def export_network(source: "Source", int8: bool, parity_maps: int) -> ExportedPair:
    """One network as ONNX in every variant, each compared with what the source answers.

    Raises ModelError if the float32 file says another class than the network.
    """
    contract = _contract(source.info)
    pair, layout, encoding = contract.pair, contract.layout, contract.encoding
    models = {"float32": source.model}
    if int8:
        maps = trial_maps(layout, contract.leg, CALIBRATION_MAPS, _CALIBRATION_SEED)
        planes = encoding.encode(maps.heights, maps.roll, maps.pitch)
        models["int8"] = quantised(source.model, planes, source.exact_parts)

    files = {
        network_file(pair, variant): with_contract(with_decoding(model), contract) for variant, model in models.items()
    }
    double = [] if source.trained is None else [double_precision(source.trained, parity_maps)]
    checks = {
        variant: Parity(files[name], name, parity_maps, double if variant == "float32" else ())
        for variant, name in zip(models, files, strict=True)
    }
    maps = trial_maps(layout, contract.leg, parity_maps, _PARITY_SEED)
    with tqdm(total=len(maps), desc=f"{pair}: parity", unit="map", disable=None) as progress:
        for batch in maps.batches(_BATCH):
            planes = encoding.encode(batch.heights, batch.roll, batch.pitch)
            expected = source.logits(planes)
            for check in checks.values():
                check.update(batch, planes, expected)
            progress.update(len(batch))
    for check in checks.values():
        check.require_decoding()
    checks["float32"].require_classes()
    reports = {variant: check.to_dict(maps.origin) for variant, check in checks.items()}
    reports["float32"].update(source.comparison)
    return ExportedPair(files, reports)


def _contract(info: Mapping[str, Any]) -> ModelContract:
    return ModelContract(
        robot=info["robot"],
        pair=info["pair"],
        leg=TRAINED_LEG[info["pair"]],
        frame=FRAME,
        layout=LegLayout.from_dict(info["layout"]),
        encoding=InputEncoding.from_dict(info["encoding"]),
        classes=info["classes"],
        feasible_below=info["feasible_below"],
        distance_weight=DISTANCE_WEIGHT,
        recipe=info["recipe"]["name"],
        dataset_sha256=info["dataset_sha256"],
        version=info["version"],
        opset=OPSET,
        commit=source_commit(),
    )


def _json(values: Mapping[str, Any]) -> str:
    return json.dumps(values, indent=2, sort_keys=True) + "\n"


def _write_folder(out: Path, contents: Mapping[str, bytes]) -> None:
    """Write and check the files in a temporary folder, then move them; the checksums go last and seal the release."""
    files = {**contents, SUMS_FILE: sums_text(contents).encode()}
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{out.name}.", dir=out.parent) as name:
        draft = Path(name) / out.name
        draft.mkdir()
        for file, content in files.items():
            (draft / file).write_bytes(content)
        load_networks(draft)
        if not out.exists():
            draft.rename(out)
            return
        for file in files:
            (draft / file).replace(out / file)
    # Variants and weights of an earlier export do not belong to this one.
    known = {network_file(pair, variant) for pair in PAIRS for variant in VARIANTS} | set(map(weights_file, PAIRS))
    for stale in known - set(files):
        (out / stale).unlink(missing_ok=True)
