"""How fast one core multiplies matrices in float32: what a network's speed is measured against."""

import time

import numpy as np
import onnxruntime

from footsel.errors import MissingExtraError
from footsel.runtime.network import session_options

#: Sides of the square matrices: from what fits in a core's cache on. Rounds of each, of which the best counts.
_SIDES, _ROUNDS = (256, 384, 512, 768), 60

_PRODUCT = """
<ir_version: 10, opset_import: ["" : 20]>
product (float[n, n] a, float[n, n] b) => (float[n, n] c) { c = MatMul(a, b) }
"""


def matmul_gflops() -> float:
    """Best of many products on the calling thread, in 1e9 operations a second; an addition counts as one.

    By onnxruntime, which runs the networks: numpy's library may know this processor less well.
    Raises MissingExtraError where onnx is not installed.
    """
    try:
        from onnx import parser
    except ModuleNotFoundError as error:
        raise MissingExtraError("measuring a matrix product", "train", error.name or "onnx") from None

    content = parser.parse_model(_PRODUCT).SerializeToString()
    session = onnxruntime.InferenceSession(content, session_options(), providers=["CPUExecutionProvider"])
    return round(max(_best(session, side) for side in _SIDES), 1)


def _best(session: onnxruntime.InferenceSession, side: int) -> float:
    a, b = np.random.default_rng(0).random((2, side, side), dtype=np.float32)
    best = float("inf")
    for _ in range(_ROUNDS):
        start = time.perf_counter()
        session.run(None, {"a": a, "b": b})
        best = min(best, time.perf_counter() - start)
    return 2 * side**3 / best / 1e9
