"""The command line where extras are not installed: what needs none works, what needs one names it."""

import json
import subprocess
import sys

import pytest

from footsel.legs import LEGS

#: Runs the command line with the packages of every extra missing.
BARE = """
import sys
for name in ("torch", "pinocchio", "coal", "numba", "scipy", "tqdm", "joblib", "matplotlib", "jinja2", "onnx", "tomli",
             "pybullet", "av", "safetensors", "rosbags", "PIL", "plyfile", "distributed", "example_robot_data"):
    sys.modules[name] = None
from footsel.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


def bare(*arguments):
    return subprocess.run(
        [sys.executable, "-c", BARE, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=120
    )


def test_numpy_and_onnxruntime_are_enough(bumpy_map, model_folder, level_pose):
    done = bare("select", bumpy_map, *level_pose, "--model", model_folder)
    assert done.returncode == 0, done.stderr
    assert list(json.loads(done.stdout)["footholds"]) == list(LEGS)


@pytest.mark.parametrize(
    ("arguments", "extra"),
    [
        (("select", "MAP", "POSE", "--selector", "oracle"), "oracle"),
        (("select", "MAP", "POSE", "--model", "MODEL", "--plot", "p.png"), "report"),
        (("label", "MAP", "POSE", "--leg", "LF", "--out", "l.npz"), "oracle"),
        (("dataset", "d"), "oracle"),
        (("train", "d", "r"), "train"),
        (("evaluate", "m", "d", "--out", "m.json"), "train"),
        (("export", "r", "o"), "train"),
        (("terrain-cost", "fit", "o"), "sim"),
        (("walk", "--terrain", "flat"), "sim"),
        (("compare", "--walk", "flat", "--out", "d"), "sim"),
        (("select", "cloud.ply", "POSE"), "maps"),
    ],
)
def test_a_missing_extra_is_named(bumpy_map, model_folder, level_pose, tmp_path, monkeypatch, arguments, extra):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cloud.ply").write_bytes(b"ply\n")
    before = sorted(tmp_path.iterdir())
    values = {"MAP": (bumpy_map,), "MODEL": (model_folder,), "POSE": level_pose}
    done = bare(*(word for argument in arguments for word in values.get(argument, (argument,))))
    assert done.returncode == 2, done
    assert done.stderr.startswith("footsel: error: ") and done.stderr.count("\n") == 1
    assert f"pip install 'footsel[{extra}]'" in done.stderr
    assert sorted(tmp_path.iterdir()) == before


def test_robots_are_listed_without_a_robot_model():
    if sys.version_info < (3, 11):
        pytest.skip("descriptions are read with tomli there")
    done = bare("robots")
    assert done.returncode == 0 and "anymal_b" in done.stdout and "front (LF RF)" in done.stdout


def test_bench_measures_the_runtime_without_an_oracle(model_folder, tmp_path):
    out = tmp_path / "bench.json"
    done = bare("bench", "--model", model_folder, "--calls", "2", "--out", out)
    assert done.returncode == 0, done.stderr
    assert "the oracle is left out" in done.stderr and "footsel[oracle]" in done.stderr
    figures = json.loads(out.read_text())
    assert "oracle_ms_per_map" not in figures and set(figures["models"]) == {"float32"}
