"""How selection times are spread over very many calls, with the other core idle and busy."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.benchmark.cases import Case
from footsel.benchmark.machine import one_core, other_core_busy
from footsel.benchmark.timing import milliseconds, percentiles, with_progress
from footsel.errors import InputError
from footsel.files import replace_file, writing
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector

#: Bins per factor of ten, from 0.1 ms to 1 s; what lies beyond is counted in the outermost.
_BINS_PER_DECADE, _DECADES = 25, (-1, 3)
_WARM_UP = 50
#: Times are kept after so many calls, a quarter of a minute's or so.
_CALLS_PER_PART = 5000

Times = NDArray[np.float64]


def latency_histogram(
    selector: FootholdSelector, cases: Sequence[Case], calls: int, parts: Path | None = None
) -> dict[str, Any]:
    """Times of `calls` selections of each kind.

    parts: a folder that keeps the times as they come in, and from which a measurement that was ended goes on.

    {"calls", "edges_ms": (b + 1,), "one_leg": {"other_core_idle": {"counts": (b,), "p50", …, "max"}, "other_core_busy":
    …}, "four_legs": …}
    """
    edges = np.logspace(*_DECADES, (_DECADES[1] - _DECADES[0]) * _BINS_PER_DECADE + 1)
    figures: dict[str, Any] = {"calls": calls, "edges_ms": [round(float(edge), 4) for edge in edges]}
    for kind in ("one_leg", "four_legs"):
        figures[kind] = {}
        for other, busy in (("other_core_idle", False), ("other_core_busy", True)):
            with one_core(), other_core_busy(busy) as spinning:
                if spinning != busy:
                    continue  # There is no other core.
                file = None if parts is None else parts / f"{kind}, {other}.npy"
                times = _times(selector, cases, calls, kind, f"{kind}, {other}".replace("_", " "), file)
            counts, _ = np.histogram(np.clip(times, edges[0], edges[-1]), edges)
            worst = round(float(times.max()), 4)
            figures[kind][other] = {"counts": counts.tolist(), **percentiles(times, tail=True), "max": worst}
    return figures


def draw_histogram(figures: Mapping[str, Any], path: Path) -> None:
    """The histogram as a picture, by matplotlib."""
    from matplotlib.figure import Figure

    edges = figures["edges_ms"]
    figure = Figure(figsize=(9, 6), layout="constrained")
    for axes, kind in zip(figure.subplots(2, 1, sharex=True), ("one_leg", "four_legs"), strict=True):
        for other, times in figures[kind].items():
            spread = f"p50 {times['p50']:.2f}, p99.9 {times['p999']:.2f}, max {times['max']:.1f} ms"
            axes.stairs(times["counts"], edges, label=f"{other.replace('_', ' ')}: {spread}")
        axes.set(xscale="log", yscale="symlog", ylabel="calls", title=kind.replace("_", " "))
        axes.legend()
    axes.set_xlabel(f"one selection of {figures['calls']:,} [ms]")
    figure.savefig(path, dpi=120)


def _times(
    selector: FootholdSelector, cases: Sequence[Case], calls: int, kind: str, description: str, file: Path | None
) -> Times:
    times = _read(file)[:calls].tolist()
    for number in with_progress(range(len(times) - _WARM_UP, calls), description):
        case = cases[number % len(cases)]
        legs = (case.leg,) if kind == "one_leg" else LEGS
        elapsed = milliseconds(lambda: selector.select(case.elevation_map, case.pose, legs))  # noqa: B023
        if number < len(times):
            continue  # It warms up.
        times.append(elapsed)
        if file is not None and len(times) % _CALLS_PER_PART == 0:
            _write(file, np.array(times))
    return np.array(times)


def _read(file: Path | None) -> Times:
    """(n,) times that an earlier measurement has kept."""
    if file is None or not file.exists():
        return np.empty(0)
    try:
        return np.asarray(np.load(file, allow_pickle=False), dtype=np.float64).reshape(-1)
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read {file} ({error})", "delete its folder") from None


def _write(file: Path, times: Times) -> None:
    with writing(file):
        replace_file(file, lambda temporary: np.save(temporary, times))
