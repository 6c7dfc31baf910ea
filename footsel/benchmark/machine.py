"""What the figures were measured on, and how the measurement is held to one core."""

import os
import platform
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path


def cpu_name() -> str:
    """The processor's name."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


@dataclass
class CoreUse:
    """How many cores a measurement used on average; NaN while it runs.

    Below one, other programs took their share of the core and the slow percentiles are theirs.
    """

    cores: float = float("nan")


@contextmanager
def one_core() -> Iterator[CoreUse]:
    """Hold the calling thread and all that it starts to one core, where the system can; measure the cores used."""
    use = CoreUse()
    # Linux alone can.
    allowed = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
    if allowed:
        os.sched_setaffinity(0, {max(allowed)})
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        yield use
    finally:
        use.cores = round((time.process_time() - cpu) / (time.perf_counter() - wall), 3)
        if allowed:
            os.sched_setaffinity(0, allowed)
