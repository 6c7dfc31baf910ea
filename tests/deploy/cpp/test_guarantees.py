"""No allocation by our own code, one selector per thread, and nothing that crashes it."""

import json

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.runtime.contract import ModelContract


def test_no_memory_is_asked_for_by_our_own_code(cpp, released):
    """Counted in every call after the warm-up; what a call needs in all is what onnxruntime alone needs."""
    done = cpp.run("count_allocations", released)
    counts = json.loads(done.stdout)
    for ours, theirs in (
        ("select_one_leg", "onnxruntime_one_leg"),
        ("select_four_legs", "onnxruntime_four_legs"),
        ("select_four_legs_choosy", "onnxruntime_four_legs"),
        ("evaluate_batch", "onnxruntime_batch"),
        ("select_five_poses", "onnxruntime_five_poses"),
    ):
        assert counts[ours]["own_most"] == 0
        assert counts[ours]["total"] == counts[theirs]["total"]
    assert counts["evaluate_classes"]["own_most"] == 0
    assert counts["select_refused"] == {"own_most": 0, "total": 0}
    # The counters count: onnxruntime asks for some, and so does a callback that makes a vector.
    assert counts["onnxruntime_one_leg"]["total"] > 0
    assert counts["select_one_leg_spendthrift"]["own_most"] == 1
    assert counts["select_one_leg_spendthrift"]["total"] == counts["select_one_leg"]["total"] + 1


def test_siblings_in_threads_choose_alike(cpp, released):
    assert cpp.run("threads", released).stdout == b"4 of 4 threads agree\n"


@pytest.fixture
def corpus(tmp_path, handmade, anymal_layout):
    """A contract, maps in every form and a network, to be damaged."""
    rng = np.random.default_rng(0)
    files = [tmp_path / name for name in ("contract.json", "deflated.npz", "stored.npz", "fortran.npz", "network.onnx")]
    contract: ModelContract = handmade.contract(anymal_layout)
    files[0].write_text(contract.to_json())
    files[4].write_bytes(handmade.constant_model(contract))
    elevation = rng.normal(0, 0.02, (12, 15)).astype(np.float32)
    ElevationMap(elevation, 0.1).save(files[1])
    np.savez(files[2], elevation=elevation, resolution=0.1, position=np.array([1.0, 2.0]))
    np.savez(files[3], elevation=np.asfortranarray(elevation.astype(np.float64)), resolution=np.float32(0.1))
    return files


def test_ten_thousand_random_inputs_crash_nothing(cpp, model_folder, corpus):
    """Under the address and undefined-behaviour sanitizers, which end the program at the first finding."""
    inputs = 10_000
    done = cpp.run("fuzz", model_folder, inputs, 1, *corpus)
    assert done.returncode == 0, done.stderr.decode()[-4000:]
    answered = json.loads(done.stdout)
    assert answered["inputs"] == inputs
    # Neither is everything refused, nor everything taken.
    for kind, share in (("selected", 0.5), ("evaluated", 0.25), ("read", 0.25)):
        assert 0.1 * share * inputs < answered[kind] < 0.97 * share * inputs, (kind, answered)


def test_the_sanitizers_find_something(cpp):
    """The fuzzing above could fail: a read beyond a buffer ends such a program."""
    done = cpp.run("fuzz", "--overrun")
    assert done.returncode != 0
    assert b"heap-buffer-overflow" in done.stderr
