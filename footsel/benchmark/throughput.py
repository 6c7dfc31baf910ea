"""Maps per second of a network at several batch sizes: for planners that score hundreds of postures a step."""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from footsel.benchmark.cases import Case
from footsel.benchmark.machine import cores
from footsel.footholds import LegLayout
from footsel.legs import TRAINED_LEG
from footsel.runtime import Network
from footsel.runtime.model_folder import available_variants, network_file

BATCHES = (1, 4, 64, 256)
#: Maps of one measurement at least, and how many of it; the median counts.
_MAPS, _ROUNDS = 256, 5


def time_throughput(folder: Path, pair: str, cases: Sequence[Case]) -> dict[str, Any]:
    """{variant: {"one_core": {batch: maps per second}, "two_cores": …, "one_core_one_call": …}} of a model folder.

    A batch goes through encoding and network in calls of the runtime's own size; `one_call` is the network alone on the
    whole batch at once. Two cores: two threads that call the same network, each with batches of its own. Left out where
    there is but one.
    """
    networks = {variant: folder / network_file(pair, variant) for variant in available_variants(folder)}
    figures: dict[str, Any] = {variant: {} for variant in networks}
    for variant, path in networks.items():
        network = Network.load(path)
        heights = _heights(network.contract.layout, pair, cases)
        planes = network.contract.encoding.encode(heights)
        for count, name in ((1, "one_core"), (2, "two_cores")):
            with cores(count) as held:
                if held == count:
                    figures[variant][name] = _rates(lambda n: network.costs(heights[:n]), callers=count)  # noqa: B023
        with cores(1):
            figures[variant]["one_core_one_call"] = _rates(lambda n: network.run(planes[:n], "cost"))  # noqa: B023
    return figures


def _heights(layout: LegLayout, pair: str, cases: Sequence[Case]) -> np.ndarray[Any, np.dtype[np.float32]]:
    """(256, 40, 40) local maps of the pair's trained leg, cases over again if there are fewer."""
    maps = [
        layout.local_map(case.elevation_map, case.pose, TRAINED_LEG[pair]).heights for case in cases[: max(BATCHES)]
    ]
    return np.stack([maps[number % len(maps)] for number in range(max(BATCHES))])


def _rates(call: Callable[[int], object], callers: int = 1) -> dict[str, float]:
    """Maps per second of all callers together at each batch size; the sizes take turns."""

    def work(batch: int) -> None:
        for _ in range(_MAPS // batch):
            call(batch)

    times: dict[int, list[float]] = {batch: [] for batch in BATCHES}
    with ThreadPoolExecutor(callers) as pool:
        # Threads are there, and have called, before time counts.
        for batch in BATCHES:
            list(pool.map(work, [batch] * callers))
        for _ in range(_ROUNDS):
            for batch in BATCHES:
                start = time.perf_counter()
                list(pool.map(work, [batch] * callers))
                times[batch].append((time.perf_counter() - start) / (callers * _MAPS // batch * batch))
    return {str(batch): round(1 / float(np.median(each)), 1) for batch, each in times.items()}
