"""Named shapes: each is tried where its name says, and slips as everybody would expect."""

import numpy as np
import pytest

from footsel.oracle.terrain_cost import TerrainCostModel
from footsel.walking.slip import landmarks
from footsel.walking.slip.landmarks import HALF, measure


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(landmarks, "FEET", 20)
        return measure(TerrainCostModel.load(), 0.031)


def test_what_slips_and_what_does_not(found):
    measured = {name: each["measured"] for name, each in found.items()}
    assert measured["level"] < 0.01
    slopes = [measured[f"plane of {degrees} degrees"] for degrees in (10, 15, 20)]
    assert slopes == sorted(slopes) and slopes[-1] > 0.9
    assert measured["pit, one cell, 5 cm"] < 0.3 < measured["upper edge of a step of 3 cm"]
    assert measured["spike, one cell, 5 cm"] > 0.9 < measured["foot of a step of 5 cm"]


def test_the_shipped_cost_goes_with_it(found):
    cost, measured = (np.array([each[key] for each in found.values()]) for key in ("cost", "measured"))
    assert np.corrcoef(cost, measured)[0, 1] > 0.85
    assert np.abs(cost - measured).mean() < 0.15


def test_the_foot_s_cell_is_where_the_shape_begins():
    shapes = dict(landmarks.landmarks())
    upper, foot = shapes["upper edge of a step of 3 cm"], shapes["foot of a step of 2 cm"]
    assert upper[HALF, HALF] == 0 and upper[HALF + 1, HALF] == -0.03
    assert foot[HALF, HALF] == 0 and foot[HALF + 1, HALF] == 0.02
    assert (shapes["pit, 3x3 cells, 1 cm"] < 0).sum() == 9 and (shapes["pit, one cell, 1 cm"] < 0).sum() == 1
