"""The C++ library's times, as its own program measures them on the same courses."""

import json
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import footsel
from footsel.benchmark.cases import Case
from footsel.errors import InputError
from footsel.runtime.model_folder import DEFAULT_VARIANT, available_variants

#: Where `make cpp` puts it.
PROGRAM = Path(footsel.__file__).resolve().parents[1] / "build" / "cpp" / "footsel_bench"


def time_cpp(program: Path, folder: Path, cases: Sequence[Case]) -> dict[str, Any]:
    """{variant: {"network_ms", "select_one_leg_ms", "select_four_legs_ms", "maps_per_second"}} of a model folder.

    As many selections of each kind as there are cases, on the courses of all cases; the program draws its own poses.
    Raises InputError for a program that fails.
    """
    courses = {id(case.elevation_map): case.elevation_map for case in cases}
    with tempfile.TemporaryDirectory() as name:
        maps = []
        for number, course in enumerate(courses.values()):
            maps.append(Path(name) / f"{number}.npz")
            course.save(maps[-1])
        figures = {}
        for variant in available_variants(folder):
            flags = [] if variant == DEFAULT_VARIANT else [f"--{variant}"]
            command = [program, folder, *maps, "--calls", str(len(cases)), *flags]
            figures[variant] = _run([str(word) for word in command], program)
    return figures


def _run(command: list[str], program: Path) -> dict[str, Any]:
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        return dict(json.loads(done.stdout))
    except subprocess.CalledProcessError as error:
        why = (error.stderr.strip().splitlines() or [f"exit code {error.returncode}"])[-1]
    except (OSError, ValueError) as error:
        why = str(error)
    raise InputError(f"{program} does not run ({why})", "build it again: make cpp")
