"""`footsel bench`: the fields of its file. Times themselves are not tested."""

import functools
import json
import os

import numpy as np
import pytest

from footsel.benchmark import BenchmarkSize
from footsel.benchmark.cases import MOST_TILT, make_cases
from footsel.benchmark.machine import cpu_name, one_core
from footsel.benchmark.timing import percentiles
from footsel.cli.main import main
from footsel.legs import LEGS
from footsel.terrain.courses import FAMILIES


@pytest.fixture(scope="module")
def figures(tmp_path_factory, anymal_layout, handmade):
    folder = tmp_path_factory.mktemp("bench")
    files = {
        f"{pair}{end}": handmade.constant_model(handmade.contract(anymal_layout, pair))
        for pair in ("front", "hind")
        for end in (".onnx", ".int8.onnx")
    }
    model = handmade.write_folder(folder / "model", files)
    with pytest.MonkeyPatch.context() as patch:
        little = functools.partial(BenchmarkSize, naive_maps=1, stage_maps=2, stage_cells=3, margin_cells=1)
        patch.setattr("footsel.benchmark.BenchmarkSize", little)
        out = folder / "bench.json"
        arguments = ["bench", "--model", str(model), "--out", str(out), "--calls", "30", "--maps", "30"]
        assert main(arguments) == 0
    return json.loads(out.read_text())


def test_fields(figures):
    assert figures["cpu"] == cpu_name() and figures["threads"] == 1
    assert set(figures["oracle_ms_per_map"]) == {"p50", "p99"}
    assert figures["oracle_naive_ms_per_map"] > figures["oracle_ms_per_map"]["p50"] > 0
    assert figures["oracle_times_as_fast"] > 10
    assert set(figures["models"]) == {"float32", "int8"} and figures["default"] in figures["models"]
    for parts in figures["models"].values():
        assert set(parts["network_ms"]) == {"p50", "p99"}
        for select in ("select_one_leg_ms", "select_four_legs_ms"):
            assert 0 < parts[select]["p50"] <= parts[select]["p99"] <= parts[select]["p999"]
    assert set(figures["baselines"]) == {"onnxruntime_default_options"}
    # A share of one core: nothing ran on a second one. A little more than one is the clocks' rounding.
    assert 0 < figures["cores_used"]["models"] < 1.2 and 0 < figures["cores_used"]["oracle"] < 1.2


def test_groups_and_stages_of_the_oracle(figures):
    assert set(figures["oracle_ms_by_terrain"]) == {*FAMILIES, "level", "tilted"}
    assert set(figures["oracle_us_per_cell"]) == {
        "kinematic_range",
        "self_collision",
        "terrain_collision",
        "kinematic_margin",
        "terrain_cost",
    }
    for times in figures["oracle_us_per_cell"].values():
        assert 0 < times["fast"] < times["naive"]


def test_cases_mix_families_tilts_and_legs(anymal_layout):
    cases = make_cases(anymal_layout, 4 * len(FAMILIES), seed=3)
    assert [case.family for case in cases[: len(FAMILIES)]] == list(FAMILIES)
    for family in FAMILIES:
        of_family = [case for case in cases if case.family == family]
        assert {case.tilted for case in of_family} == {True, False}
    assert {case.leg for case in cases} == set(LEGS)
    for case in cases:
        assert max(abs(case.pose.roll), abs(case.pose.pitch)) <= MOST_TILT
        assert case.local_map(anymal_layout).known.all()
    again = make_cases(anymal_layout, 3, seed=3)
    assert [case.pose for case in again] == [case.pose for case in cases[:3]]


def test_percentiles():
    times = np.arange(1001) / 10
    assert percentiles(times) == {"p50": 50.0, "p99": 99.0}
    assert percentiles(times, tail=True)["p999"] == pytest.approx(99.9)


def test_one_core_is_given_back():
    before = os.sched_getaffinity(0)
    with one_core() as use:
        assert len(os.sched_getaffinity(0)) == 1
        sum(range(200_000))
    assert os.sched_getaffinity(0) == before
    assert 0 < use.cores < 1.2
