"""How fast one core multiplies matrices in float32: what a network's speed is measured against.

`python -m footsel.benchmark.peak` prints the figure; a process of its own, for a BLAS takes its number of threads from
the environment when it is loaded.
"""

import os
import subprocess
import sys
import time

import numpy as np

#: Side of the square matrices: they stay in the second-level cache or close to it. Rounds of which the best counts.
_SIDE, _ROUNDS = 768, 40


def matmul_gflops() -> float:
    """Best of some products of two matrices on one thread, in 1e9 operations a second; an addition counts as one."""
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")
    command = [sys.executable, "-m", "footsel.benchmark.peak"]
    done = subprocess.run(command, env={**os.environ, **one_thread}, capture_output=True, text=True, check=True)
    return float(done.stdout)


def _measure() -> float:
    rng = np.random.default_rng(0)
    a, b = rng.random((2, _SIDE, _SIDE), dtype=np.float32)
    product = np.empty_like(a)
    best = float("inf")
    for _ in range(_ROUNDS):
        start = time.perf_counter()
        np.matmul(a, b, out=product)
        best = min(best, time.perf_counter() - start)
    return round(2 * _SIDE**3 / best / 1e9, 1)


if __name__ == "__main__":
    print(_measure())
