"""Two small maps, a network with random filters, and one comparison on them that many tests look at."""

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.comparison.compare import Comparison, compare
from footsel.comparison.maps import NamedMap
from footsel.robot import load_robot
from footsel.terrain.courses import make_course

SELECTORS = ("oracle", "cnn", "cnn+verify", "terrain_only", "nominal")
POSES = 6
SEED = 3


@pytest.fixture(scope="session")
def maps() -> Sequence[NamedMap]:
    """Stairs with holes, and rubble in cells of 3 cm whose known part ends in the middle."""
    stairs = make_course("stairs", 1, size=3.0)
    elevation = stairs.elevation.copy()
    elevation[np.random.default_rng(0).random(elevation.shape) < 0.15] = np.nan
    rubble = make_course("rubble", 2, size=3.0, resolution=0.03)
    half_known = rubble.elevation.copy()
    half_known[:, 50:] = np.nan
    return (
        NamedMap("stairs", ElevationMap(elevation, stairs.resolution, np.array([5.0, -2.0]))),
        NamedMap("rubble", ElevationMap(half_known, rubble.resolution)),
    )


@pytest.fixture(scope="session")
def model(tmp_path_factory: pytest.TempPathFactory, handmade: SimpleNamespace) -> Path:
    """A model folder for ANYmal B whose networks are random filters, allowing most cells."""
    layout = load_robot("anymal_b").layout
    files = {
        f"{pair}.onnx": handmade.random_model(handmade.contract(layout, pair, feasible_below=0.9), seed)
        for seed, pair in enumerate(("front", "hind"))
    }
    return Path(handmade.write_folder(tmp_path_factory.mktemp("models") / "random", files))


@pytest.fixture(scope="session")
def comparison(maps: Sequence[NamedMap], model: Path) -> Comparison:
    return compare(maps, SELECTORS, poses=POSES, seed=SEED, model=model)
