"""What `pip install footsel` gives: built from its own sdist, installed where there was nothing."""

import json
import os
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

from footsel.terrain.courses import make_course

ROOT = Path(__file__).resolve().parents[2]
#: In all: the wheel with the released models.
MOST_BYTES = 25e6

pytestmark = pytest.mark.slow


def run(*command: object, cwd: Path) -> str:
    """What a command prints, with nothing of this checkout on its path."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=1200,
    )
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    return done.stdout


@pytest.fixture(scope="module")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of sdist and wheel; the wheel is built from the sdist."""
    out = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--outdir", out, ROOT, cwd=out)
    return out


@pytest.fixture(scope="module")
def wheel(dist: Path) -> Path:
    (path,) = dist.glob("footsel-*.whl")
    return path


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory, wheel: Path) -> Path:
    """The python of an environment that had nothing but pip before."""
    folder = tmp_path_factory.mktemp("bare")
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel, cwd=folder)
    return python


def test_the_sdist_holds_what_runs_on_a_robot(dist: Path) -> None:
    (path,) = dist.glob("footsel-*.tar.gz")
    with tarfile.open(path) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    sources = {str(file.relative_to(ROOT)) for file in (ROOT / "deploy").rglob("*.[ch]pp")}
    assert len(sources) > 15 and sources <= names
    assert {"deploy/cpp/CMakeLists.txt", "deploy/python/control_loop.py", "export/anymal_b/front.onnx"} <= names


def test_the_wheel_is_small_and_has_the_models(wheel: Path) -> None:
    assert wheel.stat().st_size < MOST_BYTES
    with zipfile.ZipFile(wheel) as content:
        names = set(content.namelist())
    released = {f"footsel/models/anymal_b/{file.name}" for file in (ROOT / "export" / "anymal_b").iterdir()}
    assert released <= names
    assert not any(name.startswith(("tests", "docs", "deploy", "export")) for name in names)


def test_nothing_but_numpy_and_onnxruntime_comes_along(bare: Path, tmp_path: Path) -> None:
    """Every distribution is one of these, needed by one of these, or pip's own."""
    code = """
import json, re
from importlib.metadata import distributions
plain = lambda name: re.sub(r"[-_.]+", "-", name).lower()
needs = {
    plain(each.metadata["Name"]): [
        plain(re.match(r"[A-Za-z0-9._-]+", line)[0]) for line in each.requires or () if "extra ==" not in line
    ]
    for each in distributions()
}
print(json.dumps(needs))
"""
    needs = json.loads(run(bare, "-c", code, cwd=tmp_path))
    assert sorted(needs["footsel"]) == ["numpy", "onnxruntime"]
    expected, waiting = {"pip", "setuptools"}, ["footsel"]
    while waiting:
        name = waiting.pop()
        if name in needs and name not in expected:
            expected.add(name)
            waiting += needs[name]
    assert set(needs) <= expected


def test_footholds_are_chosen_there(bare: Path, tmp_path: Path) -> None:
    make_course("steps", 3, 3.0).save(tmp_path / "steps.npz")
    footsel = bare.with_name("footsel")
    pose = ("--pose", "0", "0", "auto", "0", "0", "0.3")
    answer = json.loads(run(footsel, "select", tmp_path / "steps.npz", *pose, cwd=tmp_path))
    assert answer["robot"] == "anymal_b" and set(answer["footholds"]) == {"LF", "RF", "LH", "RH"}
    assert any(foothold["status"] == "ok" for foothold in answer["footholds"].values())


def test_the_runtime_finds_its_models_there(bare: Path, tmp_path: Path) -> None:
    code = """
import footsel, numpy
from footsel import ElevationMap
from footsel.runtime import FootholdSelector
selector = FootholdSelector.load("anymal_b")
flat = ElevationMap(numpy.zeros((150, 150)), 0.02)
print(footsel.__file__, *(foothold.status for foothold in selector.select(flat, (0, 0, 0.47, 0, 0, 0)).values()))
"""
    where, *statuses = run(bare, "-c", code, cwd=tmp_path).split()
    assert Path(where).is_relative_to(bare.parents[1]) and statuses == ["ok"] * 4
