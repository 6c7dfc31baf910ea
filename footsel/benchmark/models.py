"""The runtime's time per selection for every variant of a model, and other engines with the same network."""

import random
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from footsel.benchmark.cases import ROUND, Case
from footsel.benchmark.timing import milliseconds, percentiles, with_progress
from footsel.legs import LEGS, TRAINED_LEG
from footsel.runtime import FootholdSelector, Network
from footsel.runtime.model_folder import available_variants, network_file

#: Cases of each call before the first that counts: onnxruntime lays out its memory.
WARM_UP = 20
#: Calls before each round of timed ones: caches fill, and so they stay in a loop.
UNTIMED = 4

#: The pair whose network is timed by itself; the other is as large.
PAIR = "front"

#: Case -> the call to be timed. What it needs of the case is made ready outside of the clock.
Prepare = Callable[[Case], Callable[[], object]]
Name = TypeVar("Name")


def time_models(
    folder: Path, cases: Sequence[Case], baselines: Mapping[str, Prepare] | None = None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """{variant: {"network_ms", "select_one_leg_ms", "select_four_legs_ms"}} of a model folder, and in the same turns
    {name: {"network_ms"}} of baselines.

    network: one local map through encoding and network, its decoding included. select: from the elevation map to
    footholds.
    """
    calls: dict[tuple[str, str], Prepare] = {}
    for variant in available_variants(folder):
        selector = FootholdSelector.load(folder, variant)
        calls[variant, "network_ms"] = inference(Network.load(folder / network_file(PAIR, variant)))
        calls[variant, "select_one_leg_ms"] = _selection(selector, one_leg=True)
        calls[variant, "select_four_legs_ms"] = _selection(selector, one_leg=False)
    others = {(name, "network_ms"): prepare for name, prepare in (baselines or {}).items()}
    models: dict[str, Any] = {}
    beside: dict[str, Any] = {}
    for (name, figure), times in take_turns({**calls, **others}, cases, "models").items():
        found = models if (name, figure) in calls else beside
        found.setdefault(name, {})[figure] = percentiles(times, tail=True)
    return models, beside


def inference(network: Network) -> Prepare:
    """One local map of the pair's trained leg through encoding, network and decoding."""
    layout = network.contract.layout

    def prepare(case: Case) -> Callable[[], object]:
        heights = layout.local_map(case.elevation_map, case.pose, TRAINED_LEG[PAIR]).heights[None]
        return lambda: network.costs(heights, case.pose.roll, case.pose.pitch)

    return prepare


def _selection(selector: FootholdSelector, one_leg: bool) -> Prepare:
    return lambda case: lambda: selector.select(case.elevation_map, case.pose, (case.leg,) if one_leg else LEGS)


def take_turns(calls: Mapping[Name, Prepare], cases: Sequence[Case], description: str) -> dict[Name, list[float]]:
    """Times in [ms] of each call on each case.

    The calls take turns in rounds of ROUND cases, in another order each time, so that all meet the same machine. Before
    its cases are timed, a call answers those before them untimed: caches hold what a loop of this call alone leaves in
    them, as in the histogram and in C++, and no figure depends on what else is measured.
    """
    times: dict[Name, list[float]] = {name: [] for name in calls}
    for prepare in calls.values():
        for case in cases[:WARM_UP]:
            prepare(case)()
    order, shuffle = list(calls), random.Random(0).shuffle
    for start in with_progress(range(0, len(cases), ROUND), description):
        shuffle(order)
        for name in order:
            for before in range(start - UNTIMED, start):
                calls[name](cases[before % len(cases)])()
            times[name] += [milliseconds(calls[name](case)) for case in cases[start : start + ROUND]]
    return times
