"""The runtime's time per selection for every variant of a model, and other engines with the same network."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import onnxruntime

from footsel.benchmark.cases import Case
from footsel.benchmark.timing import milliseconds, percentiles, with_progress
from footsel.errors import MissingExtraError
from footsel.footholds import LegLayout
from footsel.footholds.encoding import InputEncoding
from footsel.legs import LEGS, TRAINED_LEG
from footsel.runtime import FootholdSelector, Network
from footsel.runtime.model_folder import available_variants, network_file

#: Rounds before the first that counts: onnxruntime lays out its memory, caches fill.
WARM_UP = 20

#: The pair whose network is timed by itself; the other is as large.
PAIR = "front"

#: Case -> the call to be timed. What it needs of the case is made ready outside of the clock.
Prepare = Callable[[Case], Callable[[], object]]
Name = TypeVar("Name")


def time_models(folder: Path, cases: Sequence[Case]) -> dict[str, Any]:
    """{variant: {"network_ms", "select_one_leg_ms", "select_four_legs_ms"}} of a model folder.

    network: one local map through encoding and network, its decoding included. select: from the elevation map to
    footholds.
    """
    calls: dict[tuple[str, str], Prepare] = {}
    for variant in available_variants(folder):
        selector = FootholdSelector.load(folder, variant)
        calls[variant, "network_ms"] = _inference(Network.load(folder / network_file(PAIR, variant)))
        calls[variant, "select_one_leg_ms"] = _selection(selector, one_leg=True)
        calls[variant, "select_four_legs_ms"] = _selection(selector, one_leg=False)
    models: dict[str, Any] = {}
    for (variant, figure), times in _take_turns(calls, cases, "models").items():
        models.setdefault(variant, {})[figure] = percentiles(times, tail=True)
    return models


def time_default_onnxruntime(folder: Path, cases: Sequence[Case]) -> dict[str, Any]:
    """`network_ms` of a session without our options: as many threads as there are cores, spinning while they wait."""
    path = folder / network_file(PAIR)
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    network = Network(session, Network.load(path).contract)
    return {"network_ms": percentiles(_take_turns({PAIR: _inference(network)}, cases, "plain onnxruntime")[PAIR])}


def time_unsimplified(run: Path, folder: Path, cases: Sequence[Case]) -> dict[str, Any]:
    """`network_ms` of the trained network as torch exports it, nothing folded or trimmed, with our options."""
    with _needing_torch():
        from footsel.exporting.decoding import with_decoding
        from footsel.exporting.onnx_file import to_onnx, with_contract

    trained, _ = _trained(run)
    contract = Network.load(folder / network_file(PAIR)).contract
    content = with_contract(with_decoding(to_onnx(trained, len(contract.encoding.planes))), contract)
    network = Network.from_bytes(content, "the trained network")
    return {"network_ms": percentiles(_take_turns({PAIR: _inference(network)}, cases, "unsimplified")[PAIR])}


def time_torch(run: Path, cases: Sequence[Case]) -> dict[str, Any]:
    """`network_ms` of the trained network in torch, eager and on one thread.

    run: of `footsel train`, or a released model folder.
    """
    with _needing_torch():
        import torch

    trained, info = _trained(run)
    encoding, layout = InputEncoding.from_dict(info["encoding"]), LegLayout.from_dict(info["layout"])

    def prepare(case: Case) -> Callable[[], object]:
        heights = layout.local_map(case.elevation_map, case.pose, TRAINED_LEG[PAIR]).heights[None]

        def call() -> object:
            planes = torch.from_numpy(encoding.encode(heights, case.pose.roll, case.pose.pitch))
            with torch.inference_mode():
                return torch.softmax(trained(planes), dim=1).numpy()

        return call

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        return {"network_ms": percentiles(_take_turns({PAIR: prepare}, cases, "torch")[PAIR])}
    finally:
        torch.set_num_threads(threads)


@contextmanager
def _needing_torch() -> Iterator[None]:
    try:
        yield
    except ModuleNotFoundError as error:
        raise MissingExtraError("measuring torch", "train", error.name or "torch") from None


def _trained(run: Path) -> tuple[Any, dict[str, Any]]:
    """The network of a run or of a release, ready for inference, and the header of its weights."""
    with _needing_torch():
        from footsel.learning.checkpoint import read_network
        from footsel.learning.warm_start import find_weights

    return read_network(find_weights(run, PAIR))


def _inference(network: Network) -> Prepare:
    layout = network.contract.layout

    def prepare(case: Case) -> Callable[[], object]:
        heights = layout.local_map(case.elevation_map, case.pose, TRAINED_LEG[PAIR]).heights[None]
        return lambda: network.costs(heights, case.pose.roll, case.pose.pitch)

    return prepare


def _selection(selector: FootholdSelector, one_leg: bool) -> Prepare:
    return lambda case: lambda: selector.select(case.elevation_map, case.pose, (case.leg,) if one_leg else LEGS)


def _take_turns(calls: Mapping[Name, Prepare], cases: Sequence[Case], description: str) -> dict[Name, list[float]]:
    """Times in [ms] of each call on each case.

    The calls take turns on each case, so that all meet the same machine and push each other out of its caches, as a
    robot's other programs would.
    """
    times: dict[Name, list[float]] = {name: [] for name in calls}
    for prepare in calls.values():
        for case in cases[:WARM_UP]:
            prepare(case)()
    for case in with_progress(cases, description):
        for name, prepare in calls.items():
            times[name].append(milliseconds(prepare(case)))
    return times
