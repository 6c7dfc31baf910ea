"""All measurements in turn, as the values of `bench.json`."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import footsel
from footsel.benchmark.cases import make_cases
from footsel.benchmark.machine import cpu_name, one_core
from footsel.benchmark.models import time_default_onnxruntime, time_models, time_torch
from footsel.errors import MissingExtraError
from footsel.runtime import FootholdSelector
from footsel.runtime.model_folder import DEFAULT_VARIANT


@dataclass(frozen=True)
class BenchmarkSize:
    """How much is measured.

    calls: of each way to select. maps: labelled by the oracle. naive_maps: labelled by the brute-force loop.
    stage_maps, stage_cells: maps on which the oracle's stages are timed, and cells of each that the naive way does.
    margin_cells: cells in all whose kinematic margin the naive way searches.
    """

    calls: int = 2000
    maps: int = 440
    naive_maps: int = 11
    stage_maps: int = 11
    stage_cells: int = 40
    margin_cells: int = 3


def run_benchmark(
    robot: str, model: Path, run: Path | None = None, size: BenchmarkSize | None = None, seed: int = 0
) -> dict[str, Any]:
    """Measure on one core, one thread; other engines that cannot be held to it are measured after.

    model: folder of a released model. run: of `footsel train`, to measure torch too.
    The oracle is left out where its packages are not installed.
    Raises ModelError for a model or a run that cannot be used, MissingExtraError for a run where torch is missing.
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
    baselines = {}
    with one_core() as model_use:
        if run is not None:
            baselines["torch_eager"] = time_torch(run, cases[: max(size.calls // 10, 1)])
        models = time_models(model, cases[: size.calls])
    with one_core() as oracle_use:
        figures.update(_oracle_figures(robot, size, seed))
    baselines["onnxruntime_default_options"] = time_default_onnxruntime(model, cases[: size.calls])
    return {
        **figures,
        # Below one, other programs took part of the core, and the slow percentiles are theirs.
        "cores_used": {"oracle": oracle_use.cores, "models": model_use.cores},
        "default": DEFAULT_VARIANT,
        "models": models,
        "baselines": baselines,
    }


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
