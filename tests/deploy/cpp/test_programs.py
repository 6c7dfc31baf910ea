"""footsel_select and footsel_bench, as a user runs them."""

import json
import re

import numpy as np
import pytest

import footsel
from footsel import ElevationMap
from footsel.benchmark.cases import make_cases
from footsel.benchmark.cpp import time_cpp
from footsel.cli.main import main
from footsel.runtime import FootholdSelector
from footsel.runtime.model_folder import available_variants
from footsel.terrain.courses import make_course

POSE = ("0.1", "-0.05", "0.55", "0.05", "-1e-02", "0.7")


@pytest.fixture
def rough(tmp_path):
    path = tmp_path / "rough.npz"
    make_course("rough", 3, 2.4).save(path)
    return path


def test_select_prints_what_the_command_prints(cpp, released, rough, capsys):
    options = ["--pose", *POSE, "--legs", "RF", "LH", "--top-k", "4"]
    done = cpp.run("footsel/footsel_select", released, rough, *options)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert main(["select", str(rough), *options]) == 0
    expected = json.loads(capsys.readouterr().out)

    def shape(value):
        if isinstance(value, dict):
            return {key: shape(member) for key, member in value.items()}
        return len(value) if isinstance(value, list) else None

    assert shape(found) == shape(expected)
    assert found["pose"] == pytest.approx(expected["pose"])
    for leg, foothold in expected["footholds"].items():
        assert found["footholds"][leg]["cell"] == foothold["cell"]
        assert found["footholds"][leg]["position"] == pytest.approx(foothold["position"], abs=1e-5)
    assert found["time_ms"]["total"] >= found["time_ms"]["network"] > 0


def write_stored(course, path):
    np.savez(path, elevation=course.elevation, resolution=course.resolution, ignored=np.array(["text"]))


def write_deflated(course, path):
    np.savez_compressed(path, elevation=course.elevation, resolution=np.float32(course.resolution), position=[0.0, 0.0])


def write_fortran_doubles(course, path):
    np.savez(path, elevation=np.asfortranarray(course.elevation, dtype=np.float64), resolution=course.resolution)


@pytest.mark.parametrize("write", [write_stored, write_deflated, write_fortran_doubles])
def test_every_form_of_a_map_is_read(cpp, released, tmp_path, write):
    course, path = make_course("rough", 3, 2.4), tmp_path / "map.npz"
    ElevationMap(course.elevation, np.float32(course.resolution)).save(path)
    expected = json.loads(cpp.run("footsel/footsel_select", released, path, "--pose", *POSE).stdout)
    write(course, path)
    found = json.loads(cpp.run("footsel/footsel_select", released, path, "--pose", *POSE).stdout)
    for leg, foothold in expected["footholds"].items():
        assert found["footholds"][leg]["position"] == pytest.approx(foothold["position"], abs=1e-5)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "usage:"),
        (["{model}", "{map}"], "usage:"),
        (["{model}", "{map}", "--pose", "1", "2"], "usage:"),
        (["{model}", "{map}", "--pose", "0", "0", "x", "0", "0", "0"], "usage:"),
        (["{model}", "{map}", "--pose", "9", "0", "0.5", "0", "0", "0"], "off the map"),
        (["{model}", "{map}", "--pose", "nan", "0", "0.5", "0", "0", "0"], "six finite numbers"),
        (["{model}", "nowhere.npz", "--pose", *POSE], "cannot read nowhere.npz"),
        (["{model}", "{model}", "--pose", *POSE], "anymal_b; give an elevation map .npz"),
        (["{model}", "{model}/front.onnx", "--pose", *POSE], "no elevation map"),
        (["nowhere", "{map}", "--pose", *POSE], "nowhere has no SHA256SUMS"),
    ],
)
def test_wrong_use(cpp, released, rough, words, message):
    done = cpp.run("footsel/footsel_select", *(word.format(model=released, map=rough) for word in words))
    assert done.returncode == 2
    assert message in done.stderr.decode()
    assert done.stdout == b""


def test_bench_prints_the_figures_of_the_table(cpp, released, rough):
    done = cpp.run("footsel/footsel_bench", released, rough, "--calls", "3")
    figures = json.loads(done.stdout)
    for stage in ("network_ms", "select_one_leg_ms", "select_four_legs_ms"):
        assert 0 < figures[stage]["p50"] <= figures[stage]["p99"] <= figures[stage]["p999"]
    assert set(figures["evaluate_ms"]) == set(figures["maps_per_second"]) == {"1", "4", "64", "256"}
    assert all(rate > 0 for rate in figures["maps_per_second"].values())


def test_the_benchmark_in_python_prints_them_too(cpp, released):
    """On the courses of its own cases, which take turns."""
    cases = make_cases(FootholdSelector.load(released).layout, 3, seed=0)
    figures = time_cpp(cpp.folder / "footsel" / "footsel_bench", released, cases)
    assert set(figures) == set(available_variants(released))
    assert figures["float32"]["calls"] == 3
    for stage in ("network_ms", "select_one_leg_ms", "select_four_legs_ms"):
        assert figures["float32"][stage]["p50"] > 0


def test_the_package_has_the_version_of_footsel(cpp):
    version = (cpp.folder / "footsel" / "footsel-config-version.cmake").read_text()
    assert re.search(r'set\(PACKAGE_VERSION "(.*)"\)', version)[1] == footsel.__version__
