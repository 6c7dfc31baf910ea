"""What `cmake --install` lays down is enough for a project of someone else's."""

import subprocess

import numpy as np
import pytest


def run(*command):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, timeout=300)


@pytest.fixture(scope="module")
def installed(cpp, tmp_path_factory):
    prefix = tmp_path_factory.mktemp("prefix")
    done = run("cmake", "--install", cpp.folder / "footsel", "--prefix", prefix)
    assert done.returncode == 0, done.stderr
    return prefix


def configure(installed, folder, request, *options):
    consumer = request.path.parent / "consumer"
    return run("cmake", "-S", consumer, "-B", folder, f"-DCMAKE_PREFIX_PATH={installed}", *options)


def test_a_project_finds_builds_and_runs(cpp, installed, released, tmp_path, request):
    done = configure(installed, tmp_path, request, f"-DONNXRUNTIME_ROOT={cpp.onnxruntime_root}")
    assert done.returncode == 0, done.stderr
    done = run("cmake", "--build", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert run(tmp_path / "consumer", released).stdout == "ok\n"


def test_without_onnxruntime_cmake_says_what_to_give(installed, tmp_path, request):
    done = configure(installed, tmp_path, request, "-DONNXRUNTIME_ROOT=/nowhere")
    assert done.returncode != 0
    assert "-DONNXRUNTIME_ROOT=<its folder>" in " ".join(done.stderr.split())


def test_installed_programs_find_their_library(installed, released, tmp_path):
    assert {path.name for path in (installed / "bin").iterdir()} == {"footsel_bench", "footsel_select"}
    np.savez(tmp_path / "flat.npz", elevation=np.zeros((100, 100), np.float32), resolution=0.02)
    pose = ("--pose", 0, 0, 0.48, 0, 0, 0)
    done = run(installed / "bin" / "footsel_select", released, tmp_path / "flat.npz", *pose)
    assert done.returncode == 0, done.stderr


def test_installed_headers(installed):
    headers = {path.name for path in (installed / "include" / "footsel").iterdir()}
    assert {"footsel.hpp", "foothold_selector.hpp", "elevation_map.hpp"} <= headers
