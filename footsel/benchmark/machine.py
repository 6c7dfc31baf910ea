"""What the figures were measured on, and how the measurement is held to one core."""

import os
import platform
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

#: Widest arithmetic of a core, the widest first: without AVX-512 the same network takes several times as long.
ARITHMETIC = {"avx512f": "AVX-512", "avx2": "AVX2", "asimd": "NEON"}
CPUINFO = Path("/proc/cpuinfo")


def cpu_name(cpuinfo: Path = CPUINFO) -> str:
    """The processor's name with its widest arithmetic; virtual machines call very different ones by the same name."""
    try:
        lines = cpuinfo.read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    # Of the first core.
    entries = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in reversed(lines))}
    name = entries.get("model name") or platform.processor() or platform.machine()
    flags = (entries.get("flags") or entries.get("Features") or "").split()
    widest = next((words for flag, words in ARITHMETIC.items() if flag in flags), None)
    return name if widest is None else f"{name} with {widest}"


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
    with cores(1):
        wall, cpu = time.perf_counter(), time.process_time()
        try:
            yield use
        finally:
            use.cores = round((time.process_time() - cpu) / (time.perf_counter() - wall), 3)


@contextmanager
def cores(count: int) -> Iterator[int]:
    """Hold the calling thread and all that it starts to `count` cores, or to those there are; yields how many."""
    allowed = _allowed()
    chosen = set(sorted(allowed)[-count:])
    if chosen:
        os.sched_setaffinity(0, chosen)
    try:
        yield len(chosen) or min(count, os.cpu_count() or 1)
    finally:
        if allowed:
            os.sched_setaffinity(0, allowed)


@contextmanager
def other_core_busy(busy: bool = True) -> Iterator[bool]:
    """Let a process spin on a core that this thread, held by `one_core`, does not use; yields whether it does."""
    others = sorted(set(range(os.cpu_count() or 1)) - _allowed())
    if not (busy and others and _allowed()):
        yield False
        return
    code = f"import os; os.sched_setaffinity(0, {{{others[-1]}}}); print('spinning', flush=True)\nwhile True: pass"
    spinning = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    try:
        # It ends at once where it may not have that core.
        yield bool(spinning.stdout and spinning.stdout.readline())
    finally:
        spinning.kill()
        spinning.communicate()


def _allowed() -> set[int]:
    """Cores that this thread may run on; Linux alone can say."""
    return os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
