"""The folder that keeps finished walks, so that a killed command goes on where it stopped.

`runs/` holds a file per walk: the question it answers, its result and its trace. More terrains, selectors and seeds may
be asked for later; another robot or map, or other software, would be another comparison.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import footsel
from footsel.claim import CONFIG, claim_folder, sole_process
from footsel.errors import InputError, MissingExtraError
from footsel.files import leftovers, write_json
from footsel.fingerprint import LABEL_SOURCES, sources_fingerprint
from footsel.walking.result import WalkResult
from footsel.walking.runs.job import WalkJob
from footsel.walking.runs.trace import Trace

RUNS = "runs"
#: Rooms whose code decides a walk, and libraries whose arithmetic does.
_SOURCES = (*LABEL_SOURCES, "runtime", "selectors", "mapping", "walking")
_LIBRARIES = ("numpy", "scipy", "numba", "pin", "coal", "pybullet", "onnxruntime")


@contextmanager
def held_folder(folder: Path, robot: str, map_name: str) -> Iterator[None]:
    """Hold a new folder, or one with walks of this robot and kind of map by this software.

    Raises InputError if it holds something else or another process works in it.
    """
    with sole_process(folder, "walks"):
        for leftover in (*leftovers(folder / CONFIG), *(folder / RUNS).glob(".*.tmp.json")):
            leftover.unlink()
        claim_folder(folder, "comparison of walks", {"robot": robot, "map": map_name, "versions": versions()})
        (folder / RUNS).mkdir(exist_ok=True)
        yield


@cache
def versions() -> dict[str, str]:
    """Of footsel's code and of the libraries that a walk's numbers come from.

    Raises MissingExtraError if a library is not installed; none is loaded.
    """
    found = {"footsel": footsel.__version__, "source": sources_fingerprint(*_SOURCES)}
    for library in _LIBRARIES:
        try:
            found[library] = metadata.version(library)
        except metadata.PackageNotFoundError:
            raise MissingExtraError("walking", "sim", library) from None
    return found


def keep(folder: Path, job: WalkJob, result: WalkResult, trace: Trace) -> None:
    """Write what came of a walk; the file is there whole or not at all."""
    write_json(
        folder / RUNS / job.file_name,
        {"question": job.question(), "result": result.to_dict(), "trace": trace.to_dict()},
    )


def kept(folder: Path, job: WalkJob) -> tuple[WalkResult, Trace] | None:
    """What came of a walk earlier; None if it was not walked or its file is damaged.

    Raises InputError if the file answers another question: a map or a model has changed under its name.
    """
    path = folder / RUNS / job.file_name
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        question, result, trace = values["question"], WalkResult(**values["result"]), Trace.from_dict(values["trace"])
    except (FileNotFoundError, ValueError, KeyError, TypeError):
        return None
    differing = _differing(question, json.loads(json.dumps(job.question())))
    if differing:
        raise InputError(f"{path} was walked with another {differing}", "choose another folder or delete the file")
    return result, trace


def _differing(found: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    return ", ".join(name.replace("_", " ") for name, value in wanted.items() if found.get(name) != value)
