"""The same network in other hands: torch, and onnxruntime without what makes ours fast."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import onnxruntime

from footsel.benchmark.cases import Case
from footsel.benchmark.models import PAIR, Prepare, inference, take_turns
from footsel.benchmark.timing import percentiles
from footsel.errors import MissingExtraError
from footsel.footholds import LegLayout
from footsel.footholds.encoding import InputEncoding
from footsel.legs import TRAINED_LEG
from footsel.runtime import Network
from footsel.runtime.model_folder import network_file


@contextmanager
def torch_baselines(run: Path | None, folder: Path) -> Iterator[dict[str, Prepare]]:
    """ "torch_eager", the trained network in torch on one thread, and "onnxruntime_unsimplified", as torch exports it.

    The second has nothing folded or trimmed, and runs with our options.
    run: of `footsel train`, or a released model folder; without one there are no baselines.
    """
    if run is None:
        yield {}
        return
    with _needing_torch():
        import torch

        from footsel.learning.checkpoint import read_network
        from footsel.learning.warm_start import find_weights
    trained, info = read_network(find_weights(run, PAIR))
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield {"torch_eager": _eager(trained, info), "onnxruntime_unsimplified": _unsimplified(trained, folder)}
    finally:
        torch.set_num_threads(threads)


def time_default_options(folder: Path, cases: Sequence[Case]) -> dict[str, Any]:
    """`network_ms` of a session without our options: as many threads as there are cores, spinning while they wait; and
    `in_turns_with_it`, the same of ours.

    Spinning threads cannot be held to one core, so this has turns of its own.
    """
    path = folder / network_file(PAIR)
    ours = Network.load(path)
    plain = Network(onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"]), ours.contract)
    times = take_turns({"plain": inference(plain), "ours": inference(ours)}, cases, "plain onnxruntime")
    return {
        "network_ms": percentiles(times["plain"], tail=True),
        "in_turns_with_it": percentiles(times["ours"], tail=True),
    }


def _eager(trained: Any, info: dict[str, Any]) -> Prepare:
    import torch

    encoding, layout = InputEncoding.from_dict(info["encoding"]), LegLayout.from_dict(info["layout"])

    def prepare(case: Case) -> Callable[[], object]:
        heights = layout.local_map(case.elevation_map, case.pose, TRAINED_LEG[PAIR]).heights[None]

        def call() -> object:
            planes = torch.from_numpy(encoding.encode(heights, case.pose.roll, case.pose.pitch))
            with torch.inference_mode():
                return torch.softmax(trained(planes), dim=1).numpy()

        return call

    return prepare


def _unsimplified(trained: Any, folder: Path) -> Prepare:
    with _needing_torch():
        from footsel.exporting.decoding import with_decoding
        from footsel.exporting.onnx_file import to_onnx, with_contract

    contract = Network.load(folder / network_file(PAIR)).contract
    content = with_contract(with_decoding(to_onnx(trained, len(contract.encoding.planes))), contract)
    return inference(Network.from_bytes(content, "the trained network"))


@contextmanager
def _needing_torch() -> Iterator[None]:
    try:
        yield
    except ModuleNotFoundError as error:
        raise MissingExtraError("measuring torch", "train", error.name or "torch") from None
