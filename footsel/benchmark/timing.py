"""Stopwatch and percentiles."""

import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")


def milliseconds(call: Callable[[], Any]) -> float:
    """Wall time of one call, in [ms]."""
    start = time.perf_counter()
    call()
    return (time.perf_counter() - start) * 1e3


def percentiles(times: Iterable[float], *, tail: bool = False) -> dict[str, float]:
    """p50 and p99 of some times, and p999 with `tail`, in their unit."""
    values = np.fromiter(times, dtype=np.float64)
    wanted = {"p50": 50.0, "p99": 99.0, **({"p999": 99.9} if tail else {})}
    return {name: round(float(np.percentile(values, share)), 4) for name, share in wanted.items()}


def with_progress(items: Iterable[T], description: str) -> Iterator[T]:
    """The items, with a bar on stderr where tqdm is installed; the bare runtime measures without."""
    try:
        from tqdm import tqdm
    except ModuleNotFoundError:
        return iter(items)
    return iter(tqdm(items, desc=description, disable=None))
