"""Surfaces that scorers are asked about, sampled at the cells of a local map."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from footsel.footholds import LegLayout
from footsel.selectors.classic import SCORERS, Judgement, TerrainScorer
from footsel.terrain.local_map import cell_offsets

Array = NDArray[np.float64]

#: Side of a local map, whatever the size of its cells. [m]
SIDE = 0.8


def sample(surface: Callable[[Array, Array], Array], resolution: float = 0.02) -> Array:
    """(n, n) heights of a surface z(x, y) at the cells' centres, in [m]."""
    xy = cell_offsets(round(SIDE / resolution), resolution)
    return np.asarray(surface(xy[..., 0], xy[..., 1]) + np.zeros(xy.shape[:2]))


def effective(judgement: Judgement) -> Array:
    """(n, n) badness in [0, 1], 1 where a cell is refused."""
    return np.where(judgement.acceptable, np.minimum(judgement.badness, 1.0), 1.0)


def plane(slope: float, direction: float = 0.0) -> Callable[[Array, Array], Array]:
    """A plane that rises by `slope` in [rad] towards `direction` in [rad]."""
    return lambda x, y: np.tan(slope) * (np.cos(direction) * x + np.sin(direction) * y)


def bumps(x: Array, y: Array) -> Array:
    """Smooth waves, 4 cm high and 30 to 40 cm long."""
    return 0.02 * np.sin(2 * np.pi * (x + 0.03) / 0.3) * np.cos(2 * np.pi * y / 0.4) + 0.05 * x


@pytest.fixture(params=SCORERS)
def name(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture
def scorer(name: str, anymal_layout: LegLayout) -> TerrainScorer:
    return SCORERS[name](anymal_layout)


@pytest.fixture
def make_scorer(anymal_layout: LegLayout) -> Callable[[str], TerrainScorer]:
    return lambda name: SCORERS[name](anymal_layout)


@pytest.fixture
def ground() -> SimpleNamespace:
    """The functions above."""
    return SimpleNamespace(sample=sample, effective=effective, plane=plane, bumps=bumps)
