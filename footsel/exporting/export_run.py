"""`footsel export`: the two networks of a training run become a released model folder."""

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from footsel.errors import InputError, MissingExtraError, ModelError
from footsel.footholds import DISTANCE_WEIGHT, LegLayout
from footsel.footholds.encoding import InputEncoding
from footsel.legs import PAIRS, TRAINED_LEG
from footsel.runtime.contract import ModelContract
from footsel.runtime.model_folder import SUMS_FILE, VARIANTS, load_networks, network_file, sums_text
from footsel.runtime.network import Network

try:
    import torch
    from tqdm import tqdm

    from footsel.exporting.onnx_file import to_onnx, with_contract
    from footsel.exporting.parity import Parity, compare, require, trained_logits
    from footsel.exporting.quantise import quantised
    from footsel.exporting.simplify import simplified
    from footsel.exporting.trial_maps import trial_maps
    from footsel.learning.checkpoint import load_network, released_weights
    from footsel.learning.files import weights_file
    from footsel.learning.network import FootholdNetwork
except ImportError as error:
    raise MissingExtraError("exporting a model", "train", error.name or "torch") from None

from footsel.exporting.model_card import model_card

#: Maps on which torch and the exported file are compared, and maps that set the ranges of the 8-bit variant.
PARITY_MAPS, CALIBRATION_MAPS = 500, 300
_PARITY_SEED, _CALIBRATION_SEED = 1, 2


@dataclass(frozen=True)
class ExportedPair:
    """The files of one pair of legs, and how far each is from the network that was trained.

    files: name -> content. parity: variant -> report.
    """

    files: Mapping[str, bytes]
    parity: Mapping[str, Parity]


def export_run(run: str | Path, out: str | Path, int8: bool = False, parity_maps: int = PARITY_MAPS) -> Path:
    """Write the model folder `out` from the run's `front` and `hind` networks and return its path.

    int8: add a quantised variant of each network.
    parity_maps: number of maps on which every file is compared with the trained network.

    Nothing is written if a network is missing, or if a float32 file says another class than its network. Files that
    `out` held before are replaced.
    """
    run, out = Path(run), Path(out)
    if out.exists() and not out.is_dir():
        raise InputError(f"{out} is a file", "give a folder to write the model to")
    trained = {pair: _load_pair(run / pair, pair) for pair in PAIRS}
    infos = {pair: info for pair, (_, info) in trained.items()}
    pairs = {}
    for pair in tqdm(PAIRS, desc="export", unit="network", disable=None):
        pairs[pair] = export_network(*trained[pair], int8, parity_maps)
    parity = {
        pair: {variant: report.to_dict() for variant, report in exported.parity.items()}
        for pair, exported in pairs.items()
    }
    metrics = {pair: info["validation"] for pair, info in infos.items()}
    networks = {name: content for exported in pairs.values() for name, content in exported.files.items()}
    for pair, (network, info) in trained.items():
        networks[weights_file(pair)] = released_weights(network.state_dict(), info)
    texts = {
        "metrics.json": _json({"robot": infos["front"]["robot"], **metrics}),
        "parity.json": _json(parity),
        "model_card.md": model_card(infos, parity, {name: len(content) for name, content in networks.items()}),
    }
    _write_folder(out, {**networks, **{name: text.encode() for name, text in texts.items()}})
    return out


def export_network(trained: FootholdNetwork, info: Mapping[str, Any], int8: bool, parity_maps: int) -> ExportedPair:
    """One network, with the header of its file, as ONNX in every variant, each compared with the network in torch.

    Raises ModelError if the float32 file says another class than the network.
    """
    contract = _contract(info)
    pair, encoding, leg = contract.pair, contract.encoding, TRAINED_LEG[contract.pair]
    with torch.no_grad():
        graph = to_onnx(simplified(trained, trained.in_channels), trained.in_channels)
    graphs = {"float32": graph}
    if int8:
        maps = trial_maps(contract.layout, leg, CALIBRATION_MAPS, _CALIBRATION_SEED)
        planes = encoding.encode(maps.heights, maps.roll, maps.pitch)
        graphs["int8"] = quantised(graph, planes, trained.exact_parts)

    maps = trial_maps(contract.layout, leg, parity_maps, _PARITY_SEED)
    expected = trained_logits(trained, encoding, maps)
    files, reports = {}, {}
    for variant, model in graphs.items():
        name = network_file(pair, variant)
        files[name] = with_contract(model, contract)
        reports[variant] = compare(expected, Network.from_bytes(files[name], name), maps)
    require(reports["float32"], network_file(pair))
    return ExportedPair(files, reports)


def _load_pair(folder: Path, pair: str) -> tuple[FootholdNetwork, dict[str, Any]]:
    trained, info = load_network(folder)
    if info["pair"] != pair:
        raise ModelError(f"{folder} was trained for the {info['pair']} legs", f"put the {pair} run there")
    return trained, info


def _contract(info: Mapping[str, Any]) -> ModelContract:
    return ModelContract(
        robot=info["robot"],
        pair=info["pair"],
        layout=LegLayout.from_dict(info["layout"]),
        encoding=InputEncoding.from_dict(info["encoding"]),
        classes=info["classes"],
        feasible_below=info["feasible_below"],
        distance_weight=DISTANCE_WEIGHT,
        recipe=info["recipe"]["name"],
        dataset_sha256=info["dataset_sha256"],
        version=info["version"],
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
    # Variants of an earlier export do not belong to this one.
    for stale in {network_file(pair, variant) for pair in PAIRS for variant in VARIANTS} - set(files):
        (out / stale).unlink(missing_ok=True)
