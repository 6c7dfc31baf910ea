"""All measurements in turn, as the values of `bench.json`."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import onnxruntime

import footsel
from footsel.benchmark.baselines import time_default_options, torch_baselines
from footsel.benchmark.cases import Case, make_cases
from footsel.benchmark.cpp import PROGRAM, time_cpp
from footsel.benchmark.histogram import latency_histogram
from footsel.benchmark.machine import cpu_name, one_core, other_core_busy
from footsel.benchmark.models import PAIR, time_models
from footsel.benchmark.multiply_adds import multiply_adds
from footsel.benchmark.peak import matmul_gflops
from footsel.benchmark.throughput import time_throughput
from footsel.claim import claim_folder
from footsel.errors import MissingExtraError
from footsel.runtime import FootholdSelector
from footsel.runtime.model_folder import (
    DEFAULT_VARIANT,
    SUMS_FILE,
    available_models,
    checksum,
    find_model_folder,
    network_file,
)


@dataclass(frozen=True)
class BenchmarkSize:
    """How much is measured.

    calls: of each way to select. maps: labelled by the oracle. naive_maps: labelled by the brute-force loop.
    histogram_calls: of each kind for the latency histogram; 0 for none.
    stage_maps, stage_cells: maps on which the oracle's stages are timed, and cells of each that the naive way does.
    margin_cells: cells in all whose kinematic margin the naive way searches.
    """

    calls: int = 2000
    maps: int = 440
    naive_maps: int = 11
    histogram_calls: int = 0
    stage_maps: int = 11
    stage_cells: int = 40
    margin_cells: int = 3


def run_benchmark(
    robot: str,
    model: Path,
    run: Path | None = None,
    size: BenchmarkSize | None = None,
    seed: int = 0,
    cpp: Path = PROGRAM,
    parts: Path | None = None,
) -> dict[str, Any]:
    """Measure on one core, one thread; other engines that cannot be held to it are measured after.

    model: folder of a released model. run: of `footsel train`, or a model folder, to measure torch too.
    cpp: the C++ library's own benchmark. parts: folder of the latency histogram, which goes on from there.
    The oracle is left out where its packages are not installed, the C++ library where it is not built.
    Raises ModelError for a model or a run that cannot be used, MissingExtraError for a run where torch is missing,
    InputError for a program that fails and for parts of another configuration.
    """
    size = size or BenchmarkSize()
    layout = FootholdSelector.load(model).layout
    cases = make_cases(layout, max(size.calls, size.maps, 2), seed)
    figures: dict[str, Any] = {
        "cpu": cpu_name(),
        "threads": 1,
        "version": footsel.__version__,
        "robot": robot,
        "model": model.name,
        "seed": seed,
    }
    with one_core() as model_use:
        with torch_baselines(run, model) as others:
            models, baselines = time_models(model, cases[: size.calls], others)
        speed = _speed(model, models)
        figures["other_models"] = {
            folder.name: time_models(folder, cases[: size.calls])[0][DEFAULT_VARIANT]
            for folder in _other_models(robot, model)
        }
        with other_core_busy() as spinning:
            busy = time_models(model, cases[: size.calls])[0] if spinning else {}
    with one_core():
        figures["cpp"] = _cpp_figures(cpp, model, cases[: size.calls])
    with one_core() as oracle_use:
        figures.update(_oracle_figures(robot, size, seed))
    baselines["onnxruntime_default_options"] = time_default_options(model, cases[: size.calls])
    for variant, times in busy.items():
        models[variant]["other_core_busy"] = times
    figures["maps_per_second"] = time_throughput(model, PAIR, cases)
    if size.histogram_calls:
        if parts is not None:
            claim_folder(parts, "latency histogram", _configuration(model, seed))
        figures["histogram"] = latency_histogram(FootholdSelector.load(model), cases, size.histogram_calls, parts)
    return {
        **figures,
        **speed,
        # Below one, other programs took part of the core, and the slow percentiles are theirs.
        "cores_used": {"oracle": oracle_use.cores, "models": model_use.cores},
        "default": DEFAULT_VARIANT,
        "models": models,
        "baselines": baselines,
    }


def _other_models(robot: str, model: Path) -> list[Path]:
    """Folders of what else is released for a robot: stock ERFNet, as the paper has it."""
    folders = [find_model_folder(name) for name in available_models()]
    return [each for each in folders if each.name != model.name and FootholdSelector.load(each).robot == robot]


def _configuration(model: Path, seed: int) -> dict[str, Any]:
    """What all times of one histogram have in common."""
    return {
        "cpu": cpu_name(),
        "version": footsel.__version__,
        "onnxruntime": onnxruntime.__version__,
        "model": checksum((model / SUMS_FILE).read_bytes()),
        "seed": seed,
    }


def _cpp_figures(program: Path, model: Path, cases: Sequence[Case]) -> dict[str, Any]:
    if program == PROGRAM and not program.is_file():
        print("footsel: the C++ library is left out: it is not built (make cpp)", file=sys.stderr)
        return {}
    return time_cpp(program, model, cases)


def _oracle_figures(robot: str, size: BenchmarkSize, seed: int) -> dict[str, Any]:
    try:
        from footsel.benchmark.oracle import time_naive_oracle, time_oracle
        from footsel.benchmark.oracle_stages import time_stages
        from footsel.oracle import Oracle
    except MissingExtraError as error:
        print(f"footsel: the oracle is left out: {error}", file=sys.stderr)
        return {}
    oracle = Oracle.load(robot)
    cases = make_cases(oracle.robot.layout, size.maps, seed)
    return {
        **time_oracle(oracle, cases),
        **time_naive_oracle(oracle, cases[: size.naive_maps]),
        **time_stages(oracle, cases[: size.stage_maps], size.stage_cells, size.margin_cells, seed),
    }


def _speed(folder: Path, models: dict[str, Any]) -> dict[str, Any]:
    """`matmul_gflops`, and into each model its multiply-adds, its own speed and the share that is of the product's.

    Nothing where onnx is not installed.
    """
    try:
        peak = matmul_gflops()
        for variant, parts in models.items():
            count = multiply_adds(folder / network_file(PAIR, variant))
            gflops = 2 * count / parts["network_ms"]["p50"] / 1e6
            parts |= {"multiply_adds": count, "gflops": round(gflops, 1), "share_of_matmul": round(gflops / peak, 3)}
    except MissingExtraError as error:
        print(f"footsel: the share of the peak is left out: {error}", file=sys.stderr)
        return {}
    return {"matmul_gflops": peak}
