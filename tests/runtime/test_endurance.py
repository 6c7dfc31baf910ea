"""Over many calls, threads and processes: the same answers, and no memory that grows."""

import hashlib
import json
import multiprocessing
import os
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector
from footsel.runtime.model_folder import find_model_folder

MEGABYTE = 2**20
STATM = Path("/proc/self/statm")


def rough_map(seed: int) -> ElevationMap:
    rng = np.random.default_rng(seed)
    elevation = rng.uniform(-0.1, 0.1, (120, 120)).astype(np.float32)
    elevation[rng.random(elevation.shape) < 0.1 * (seed % 3)] = np.nan
    return ElevationMap(elevation, 0.02)


def pose(seed: int) -> list[float]:
    return (np.array([0, 0, 0.5, 0, 0, 0]) + np.random.default_rng(seed).uniform(-0.3, 0.3, 6)).tolist()


def digest(selector: FootholdSelector, seeds: range) -> str:
    """Of all answers, to the last bit."""
    answers = []
    for seed in seeds:
        footholds = selector.select(rough_map(seed), pose(seed), top_k=2)
        answers.append({leg: foothold.to_dict() for leg, foothold in footholds.items()})
    return hashlib.sha256(json.dumps(answers).encode()).hexdigest()


def digest_of(folder: Path, seeds: range) -> str:
    return digest(FootholdSelector.load(folder), seeds)


def test_many_threads_share_a_selector(model_folder):
    """They start together, on requests of different sizes, and change often."""
    selector = FootholdSelector.load(model_folder)
    expected = [digest(selector, range(seed, seed + 5)) for seed in range(8)]
    barrier = threading.Barrier(8)

    def work(seed: int) -> set[str]:
        barrier.wait()
        found = set()
        for _ in range(6):
            found.add(digest(selector, range(seed, seed + 5)))
            selector.select(rough_map(seed), pose(seed), legs=("RF", "LH", "LF")[: seed % 3 + 1])
            selector.select_many(rough_map(seed), [pose(seed)] * (seed + 1))
        return found

    with ThreadPoolExecutor(8) as threads:
        assert list(threads.map(work, range(8))) == [{each} for each in expected]


def test_two_processes_at_once_give_the_same_answers(model_folder):
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as processes:
        found = list(processes.map(digest_of, [model_folder] * 2, [range(30)] * 2))
    assert found == [digest_of(model_folder, range(30))] * 2


def grown(folder: Path, times: int, warm_up: int, leaking: bool = False, legs: int = 4) -> int:
    """Bytes by which this process grows over `times` calls, after some that lay out its memory.

    leaking: every call keeps a local map. legs: that a call asks for, in turn.
    """
    call, kept, page = calls(FootholdSelector.load(folder), legs), [], os.sysconf("SC_PAGE_SIZE")
    before = 0
    for number in range(warm_up + times):
        if number == warm_up:
            before = int(STATM.read_text().split()[1])
        call(number)
        if leaking:
            kept.append(np.ones((40, 40), dtype=np.float32))
    return (int(STATM.read_text().split()[1]) - before) * page


def grown_alone(*arguments: object) -> int:
    """`grown` in a process of its own: one that has run other tests has memory to spare, where a leak hides."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as processes:
        return processes.submit(grown, *arguments).result()


def calls(selector: FootholdSelector, legs: int) -> Callable[[int], object]:
    """All ways to ask, in turn; holes and borders among the maps. legs: of each call, they take turns too."""
    maps, poses = [rough_map(seed) for seed in range(3)], [pose(seed) for seed in range(50)]
    local = np.random.default_rng(0).uniform(-0.8, -0.2, (3, 40, 40))
    turns = [(*LEGS[first:], *LEGS[:first])[:legs] for first in range(len(LEGS))]
    last = {}

    def call(number: int) -> None:
        elevation_map, base, asked = maps[number % 3], poses[number % 50], turns[number % 4]
        if number % 10 == 8:
            selector.evaluate(local[: max(legs - 1, 1)], asked[0], 0.1, 0.0)
        elif number % 10 == 9:
            selector.select_many(elevation_map, [base, base], asked)
        else:
            last.update(selector.select(elevation_map, base, asked, previous=last, top_k=1 + number % 2))

    return call


needs_statm = pytest.mark.skipif(not STATM.exists(), reason="reads the size of the process from /proc")


@needs_statm
def test_memory_does_not_grow(model_folder):
    """By less than half a local map a call."""
    assert grown_alone(model_folder, 3000, 1000) < 3 * MEGABYTE


@needs_statm
def test_a_leak_would_show(model_folder):
    assert grown_alone(model_folder, 3000, 1000, True) > 3 * MEGABYTE


@needs_statm
@pytest.mark.slow
def test_memory_does_not_grow_over_a_million_calls(constant_folder):
    """By less than 8 bytes a call. One leg each and a network of one layer, so that it takes minutes, not an hour."""
    assert grown_alone(constant_folder(3), 1_000_000, 2000, False, 1) < 8 * MEGABYTE


@needs_statm
@pytest.mark.slow
def test_memory_does_not_grow_with_a_released_network():
    """Its own arena in onnxruntime: by less than half a local map a call."""
    assert grown_alone(find_model_folder("anymal_b"), 5000, 1000) < 5 * MEGABYTE
