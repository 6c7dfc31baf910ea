"""Builds the C++ programs once, and speaks with them."""

import contextlib
import fcntl
import json
import os
import shutil
import struct
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.legs import LEGS

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
SOURCES = ROOT / "deploy" / "cpp"
#: Kept between runs, so that only what changed is built again.
BUILD = ROOT / "build"
NEEDED = ("cmake", "make", "g++", "npm")

ORDERS = ("row_major", "column_major", "grid_map")


@dataclass(frozen=True)
class Case:
    """One selection, for both languages.

    verify: 0 without, 1 refuse all, 2 accept some, 3 throw. order: how the map lies in memory. null: give no heights.
    """

    elevation_map: ElevationMap | None
    pose: tuple[float, ...]
    legs: tuple[str, ...] = LEGS
    nominal: dict[str, tuple[float, ...]] = field(default_factory=dict)
    previous: dict[str, tuple[float, float]] = field(default_factory=dict)
    hysteresis: float = 10.0
    top_k: int = 1
    max_distance: float = np.inf
    verify: int = 0
    order: str = "row_major"
    null: bool = False
    #: In place of the map, for those that Python would not make: (elevation, resolution, position).
    raw: tuple[np.ndarray, float, tuple[float, float]] | None = None

    def to_bytes(self) -> bytes:
        """As drivers/case.hpp reads it."""
        if self.raw is None:
            elevation, resolution = self.elevation_map.elevation, self.elevation_map.resolution
            position = self.elevation_map.position
        else:
            elevation, resolution, position = self.raw
        points = []
        for leg in LEGS:
            point = self.nominal.get(leg, ())
            points += [len(point), *point, *[0.0] * (3 - len(point))]
        for leg in LEGS:
            points += [leg in self.previous, *self.previous.get(leg, (0.0, 0.0))]
        numbers = (
            *elevation.shape,
            resolution,
            *position,
            *self.pose,
            *(leg in self.legs for leg in LEGS),
            *points,
            self.hysteresis,
            self.top_k,
            self.max_distance,
            self.verify,
            ORDERS.index(self.order),
            self.null,
        )
        lying = {"row_major": elevation, "column_major": elevation.T, "grid_map": elevation[::-1, ::-1].T}[self.order]
        return struct.pack("<49d", *map(float, numbers)) + np.ascontiguousarray(lying, dtype="<f4").tobytes()


@dataclass(frozen=True)
class Cpp:
    """The programs in `folder`, built against the onnxruntime in `onnxruntime_root`."""

    folder: Path
    onnxruntime_root: Path

    def run(self, program: str, *arguments: object, data: bytes = b"") -> subprocess.CompletedProcess[bytes]:
        """What a program of `folder` did."""
        command = [str(self.folder / program), *map(str, arguments)]
        return subprocess.run(command, input=data, capture_output=True, check=False, timeout=300)

    def select(self, model: Path | tuple[Path, Path], cases: Iterable[Case], *options: str) -> list[dict[str, Any]]:
        """{"footholds"} or {"error"} of each case; of the model alone if that cannot be loaded."""
        places = model if isinstance(model, tuple) else (model,)
        done = self.run("run_cases", *options, *places, data=b"".join(case.to_bytes() for case in cases))
        assert done.returncode in (0, 2), done.stderr.decode()
        return [json.loads(line) for line in done.stdout.splitlines()]

    def load_error(self, model: Path | tuple[Path, Path], *options: str) -> str:
        """Why a model cannot be loaded."""
        (answer,) = self.select(model, (), *options)
        return answer["error"]


@contextlib.contextmanager
def only_one(name: str) -> Iterator[None]:
    """One process at a time; others wait."""
    BUILD.mkdir(exist_ok=True)
    with (BUILD / f"{name}.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def must(command: list[object], what: str) -> None:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, timeout=600)
    if done.returncode:
        pytest.fail(f"{what} failed:\n{done.stdout[-3000:]}\n{done.stderr[-6000:]}", pytrace=False)


@pytest.fixture(scope="session")
def cpp() -> Cpp:
    missing = [tool for tool in NEEDED if shutil.which(tool) is None]
    if missing:
        reason = f"the C++ library needs {', '.join(missing)} to be built"
        # Where nobody reads the list of what was skipped, nothing is.
        pytest.fail(reason) if os.environ.get("CI") else pytest.skip(reason)
    root = Path(os.environ.get("ONNXRUNTIME_ROOT") or BUILD / "onnxruntime").resolve()
    folder = BUILD / "cpp-tests"
    with only_one("cpp"):
        if "ONNXRUNTIME_ROOT" not in os.environ:
            must([sys.executable, SOURCES / "fetch_onnxruntime.py", root], "making a root of onnxruntime")
        configure = ["cmake", "-S", HERE, "-B", folder, "-DCMAKE_BUILD_TYPE=Release", f"-DONNXRUNTIME_ROOT={root}"]
        must(configure, "configuring the C++ programs")
        must(["cmake", "--build", folder, "--parallel", min(os.cpu_count() or 1, 4)], "building the C++ programs")
    return Cpp(folder, root)


@pytest.fixture(scope="session")
def case() -> type[Case]:
    """The class of cases, for tests."""
    return Case


@pytest.fixture(scope="session")
def released() -> Path:
    """The released model of this checkout."""
    return ROOT / "export" / "anymal_b"
