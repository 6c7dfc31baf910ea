"""`footsel bench`: the fields of its file. Times themselves are not tested."""

import functools
import itertools
import json
import os
import subprocess
import threading
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch

from footsel.benchmark import BenchmarkSize, as_table, histogram, models, throughput
from footsel.benchmark.cases import MOST_TILT, ROUND, make_cases
from footsel.benchmark.cpp import time_cpp
from footsel.benchmark.machine import cpu_name, one_core, other_core_busy
from footsel.benchmark.multiply_adds import multiply_adds
from footsel.benchmark.timing import percentiles
from footsel.cli.main import main
from footsel.errors import InputError
from footsel.exporting.onnx_file import to_onnx
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector
from footsel.runtime.model_folder import find_model_folder
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
        patch.setattr("footsel.benchmark.run.PROGRAM", folder / "footsel_bench")
        patch.setattr("footsel.benchmark.cpp.PROGRAM", folder / "footsel_bench")
        assert main([*arguments, "--histogram", "40", "--plot", str(folder / "histogram.png")]) == 0
    assert not (folder / "bench.json.parts").exists()
    assert (folder / "histogram.png").read_bytes().startswith(b"\x89PNG")
    return json.loads(out.read_text())


def test_fields(figures):
    assert figures["cpu"] == cpu_name() and figures["threads"] == 1
    assert set(figures["oracle_ms_per_map"]) == {"p50", "p99"}
    assert figures["oracle_naive_ms_per_map"] > figures["oracle_ms_per_map"]["p50"] > 0
    assert figures["oracle_times_as_fast"] > 10
    assert set(figures["models"]) == {"float32", "int8"} and figures["default"] in figures["models"]
    for parts in figures["models"].values():
        for each in (parts, parts["other_core_busy"]):
            for select in ("network_ms", "select_one_leg_ms", "select_four_legs_ms"):
                assert 0 < each[select]["p50"] <= each[select]["p99"] <= each[select]["p999"]
    # The folder that is measured is not a released one here, so both of these are others.
    assert set(figures["other_models"]) == {"anymal_b", "anymal_b_paper"}
    for parts in figures["other_models"].values():
        assert set(parts) == {"network_ms", "select_one_leg_ms", "select_four_legs_ms"}
    assert set(figures["baselines"]) == {"onnxruntime_default_options"}
    plain = figures["baselines"]["onnxruntime_default_options"]
    assert plain["network_ms"]["p50"] > 0 and plain["in_turns_with_it"]["p50"] > 0
    assert figures["cpp"] == {}
    # A share of one core: nothing ran on a second one. A little more than one is the clocks' rounding.
    assert 0 < figures["cores_used"]["models"] < 1.2 and 0 < figures["cores_used"]["oracle"] < 1.2


def test_maps_per_second(figures):
    assert set(figures["maps_per_second"]) == {"float32", "int8"}
    for rows in figures["maps_per_second"].values():
        assert set(rows) == {"one_core", "two_cores", "one_core_one_call"}
        for rates in rows.values():
            assert set(rates) == {"1", "4", "64", "256"} and min(rates.values()) > 0


@pytest.mark.parametrize("callers", [1, 2])
def test_callers_run_side_by_side_and_their_maps_add_up(monkeypatch, callers):
    together, maps, clock = threading.Barrier(callers, timeout=20), [], itertools.count()

    def call(batch):
        together.wait()  # Breaks, unless all callers are in a call at the same time.
        maps.append(batch)

    # Every measurement takes a second.
    monkeypatch.setattr(throughput.time, "perf_counter", lambda: float(next(clock)))
    rates = throughput._rates(call, callers)
    assert rates == dict.fromkeys(map(str, throughput.BATCHES), callers * throughput._MAPS)
    assert sum(maps) == callers * throughput._MAPS * len(throughput.BATCHES) * (throughput._ROUNDS + 1)


def test_histogram(figures):
    found = figures["histogram"]
    edges = found["edges_ms"]
    assert edges == sorted(edges) and (edges[0], edges[-1]) == (0.1, 1000)
    for kind in ("one_leg", "four_legs"):
        assert set(found[kind]) == {"other_core_idle", "other_core_busy"}
        for times in found[kind].values():
            assert sum(times["counts"]) == found["calls"] == 40
            assert len(times["counts"]) == len(edges) - 1
            assert times["p50"] <= times["p999"] <= times["max"]
            # The median lies in the bin where half of the counts are reached.
            middle = np.searchsorted(np.cumsum(times["counts"]), 20)
            assert edges[middle] * 0.9 < times["p50"] < edges[middle + 1] * 1.1 or times["p50"] < 0.1


@pytest.fixture
def selector(constant_folder):
    return FootholdSelector.load(constant_folder(3))


def test_a_histogram_goes_on_where_it_was_ended(selector, anymal_layout, tmp_path, monkeypatch):
    """What was measured before stays; only the rest is measured now."""
    cases = make_cases(anymal_layout, 5, seed=0)
    monkeypatch.setattr(histogram, "_CALLS_PER_PART", 4)
    before = histogram.latency_histogram(selector, cases, 10, tmp_path)["one_leg"]["other_core_idle"]
    kept = np.load(tmp_path / "one_leg, other_core_idle.npy")
    assert len(kept) == 8 and max(kept) <= before["max"] + 1e-4

    calls = []
    monkeypatch.setattr(histogram, "milliseconds", lambda call: calls.append(call) or 500.0)
    after = histogram.latency_histogram(selector, cases, 12, tmp_path)["one_leg"]["other_core_idle"]
    assert after["max"] == 500.0 and sum(after["counts"]) == 12
    again = np.load(tmp_path / "one_leg, other_core_idle.npy")
    np.testing.assert_array_equal(again, [*kept, *[500.0] * 4])
    # Four measurements that warm up and take four calls each.
    assert len(calls) == 4 * (histogram._WARM_UP + 4)


def test_a_damaged_part_is_said(selector, anymal_layout, tmp_path):
    (tmp_path / "one_leg, other_core_idle.npy").write_bytes(b"x")
    with pytest.raises(InputError, match=r"cannot read .*other_core_idle.npy .*delete its folder"):
        histogram.latency_histogram(selector, make_cases(anymal_layout, 2, seed=0), 3, tmp_path)


def test_everything_takes_turns(anymal_layout, monkeypatch):
    """Every call is timed once on each case, in rounds of changing order, right after its own calls before those."""
    cases = make_cases(anymal_layout, 62, seed=0)
    done = []
    calls = {name: lambda case, name=name: lambda: done.append((name, case)) for name in "abc"}
    monkeypatch.setattr(models, "milliseconds", lambda now: (now(), done.append("timed"))[0] or len(done))
    times = models.take_turns(calls, cases, "")
    assert {name: len(each) for name, each in times.items()} == dict.fromkeys("abc", 62)
    done = done[3 * models.WARM_UP :]
    orders = set()
    for start in range(0, 62, ROUND):
        expected = cases[start : start + ROUND]
        before = [cases[number] for number in range(start - models.UNTIMED, start)]
        order = []
        for _ in range(3):
            turn, done = done[: models.UNTIMED + 2 * len(expected)], done[models.UNTIMED + 2 * len(expected) :]
            untimed, timed = turn[: models.UNTIMED], turn[models.UNTIMED :]
            assert {name for name, _ in (*untimed, *timed[::2])} == {turn[0][0]}
            assert [case for _, case in untimed] == before and [case for _, case in timed[::2]] == expected
            assert timed[1::2] == ["timed"] * len(expected) and "timed" not in untimed
            order.append(turn[0][0])
        assert set(order) == set("abc")
        orders.add(tuple(order))
    assert not done and len(orders) > 2


@pytest.mark.parametrize("program", ["nowhere", "/bin/false"])
def test_a_program_that_does_not_run_is_said(constant_folder, anymal_layout, program):
    with pytest.raises(InputError, match=rf"{program} does not run .*make cpp"):
        time_cpp(Path(program), constant_folder(0), make_cases(anymal_layout, 2, seed=0))


def test_share_of_the_matrix_product(figures):
    assert figures["matmul_gflops"] > 0
    for parts in figures["models"].values():
        assert parts["multiply_adds"] == multiply_adds_of_the_constant_model()
        expected = 2 * parts["multiply_adds"] / parts["network_ms"]["p50"] / 1e6
        assert parts["gflops"] == pytest.approx(expected, abs=0.06)
        assert parts["share_of_matmul"] == pytest.approx(expected / figures["matmul_gflops"], abs=2e-3)


def multiply_adds_of_the_constant_model() -> int:
    """A 1x1 convolution of four planes to fourteen, four sums of fourteen, two means by products with 40x40."""
    return 1600 * (14 * 4 + 4 * 14 + 2 * 40)


def test_multiply_adds_of_each_kind_of_layer(tmp_path):
    """Strides, groups, dilations and the ways up, against torch's own shapes."""
    network = torch.nn.Sequential(
        torch.nn.Conv2d(4, 8, (3, 1), stride=2, padding=(2, 0), dilation=(2, 1)),  # 8 x 20 x 20 of 4 x 3
        torch.nn.Conv2d(8, 8, 3, padding=1, groups=4),  # 8 x 20 x 20 of 2 x 9
        torch.nn.ConvTranspose2d(8, 6, 2, stride=2),  # 8 x 20 x 20 into 6 x 4
        torch.nn.Linear(40, 7),  # 6 x 40 x 7 of 40
    )
    model = to_onnx(network.eval(), 4)
    onnx.save(model, tmp_path / "model.onnx")
    expected = 8 * 400 * 12 + 8 * 400 * 18 + 8 * 400 * 24 + 6 * 40 * 7 * 40
    assert multiply_adds(tmp_path / "model.onnx") == expected


def test_multiply_adds_of_eight_bits_are_those_of_floats():
    """A released network: its quantised layers do the same work."""
    folder = find_model_folder("anymal_b")
    float32 = multiply_adds(folder / "front.onnx")
    assert 5e6 < float32 < 1e9
    if (folder / "front.int8.onnx").is_file():
        assert multiply_adds(folder / "front.int8.onnx") == float32


def test_another_core_spins_meanwhile_and_not_after(monkeypatch):
    started = []
    start = subprocess.Popen
    monkeypatch.setattr(
        subprocess, "Popen", lambda *args, **kwargs: started.append(start(*args, **kwargs)) or started[-1]
    )
    with one_core():
        with other_core_busy() as spins:
            (process,) = started
            assert spins and process.poll() is None
            assert not os.sched_getaffinity(process.pid) & os.sched_getaffinity(0)
        assert process.poll() is not None
        with other_core_busy(False) as spins:
            assert not spins and len(started) == 1


def test_a_plot_without_a_histogram_is_refused(capsys, tmp_path):
    assert main(["bench", "--plot", str(tmp_path / "p.png")]) == 2
    assert "--plot draws the histogram; give --histogram N too" in capsys.readouterr().err


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
    rounds = [{case.leg for case in cases[start : start + ROUND]} for start in range(0, len(cases), ROUND)]
    assert all(len(legs) == 1 for legs in rounds) and rounds[0] != rounds[1]
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


def test_the_table_has_cpp_and_baselines_beside_the_variants():
    times = {"p50": 1.0, "p99": 2.0, "p999": 3.0}
    each = {"network_ms": times, "select_one_leg_ms": times, "select_four_legs_ms": times}
    text = as_table(
        {
            "cpu": "a CPU",
            "default": "float32",
            "models": {"float32": each, "int8": each},
            "other_models": {"anymal_b_paper": each},
            "cpp": {"float32": {**each, "maps_per_second": {"1": 1234.0, "256": 2345.0}}},
            "baselines": {
                "onnxruntime_unsimplified": {"network_ms": times},
                "onnxruntime_default_options": {"network_ms": times, "in_turns_with_it": times},
            },
            "maps_per_second": {"float32": {"one_core": {"1": 1000.0, "256": 2000.0}}},
        }
    )
    rows = {line[:34].strip(): line[34:].split() for line in text.splitlines()}
    for name in (
        "int8: select four legs",
        "anymal_b_paper: select four legs",
        "C++, float32: select four legs",
        "onnxruntime unsimplified: network",
        "ours in turns with it",
    ):
        assert rows[name] == ["1.000", "2.000", "3.000"]
    assert rows["C++, float32: one core"] == ["1234", "2345"]
