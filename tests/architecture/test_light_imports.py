"""The runtime loads numpy and onnxruntime, and none of the heavy packages, even when it is used."""

import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = ("torch", "pinocchio", "coal", "pybullet", "numba", "scipy", "onnx", "matplotlib", "PIL", "rosbags")

#: Walks through a selection, so that imports made late are seen too.
USE = """
import sys
import numpy as np
import footsel, footsel.runtime
from footsel.runtime import FootholdSelector, available_models
selector = FootholdSelector.load(sys.argv[1])
elevation_map = footsel.ElevationMap(np.zeros((100, 100)), 0.02)
footholds = selector.select(elevation_map, (0, 0, 0.47, 0, 0, 0), top_k=3, verify=lambda *_: True)
assert len(footholds) == 4
selector.evaluate(np.zeros((40, 40)), "RF", 0.0, 0.0)
available_models()
"""


def heavy_modules_after(code: str, *arguments: str) -> list[str]:
    """Names of HEAVY that a fresh interpreter has loaded after running `code`."""
    report = f"\nimport sys\nprint('loaded:', *[name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", code + report, *arguments], capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()[-1].split()[1:]


@pytest.mark.parametrize(
    "module", ["footsel", "footsel.runtime", "footsel.footholds", "footsel.terrain", "footsel.mapping"]
)
def test_importing_is_light(module):
    assert heavy_modules_after(f"import {module}") == []


def test_using_the_runtime_is_light(model_folder: Path):
    assert heavy_modules_after(USE, str(model_folder)) == []


@pytest.mark.parametrize("package", ["scipy", "onnx"])
def test_this_test_can_fail(package):
    assert package in heavy_modules_after(f"import footsel.runtime, {package}")
