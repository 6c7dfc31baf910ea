"""Arrays in grid_map's convention: the same map as ours, wherever its circular buffer begins."""

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.errors import MapError
from footsel.runtime import FootholdSelector
from footsel.terrain.courses import make_course

POSE = (0.3, -0.2, 0.5, 0.05, -0.03, 0.7)


def as_grid_map(terrain, start):
    """(rows, columns) buffer of a map: cell (0, 0) at +x, +y, then turned so that it begins at `start`."""
    return np.roll(terrain.elevation[::-1, ::-1], start, axis=(0, 1))


@pytest.mark.parametrize("start", [(0, 0), (1, 0), (37, 61)])
def test_the_map_is_the_same_wherever_the_buffer_begins(deployed, start):
    course = make_course("stones", 3, size=3.0).elevation[:, 20:]  # Rows and columns differ.
    terrain = ElevationMap(course, 0.02, np.array([0.3, -0.1]))
    found = deployed("grid_map").elevation_map_of(as_grid_map(terrain, start), 0.02, (0.3, -0.1), start)
    np.testing.assert_array_equal(found.elevation, terrain.elevation)
    np.testing.assert_array_equal(found.position, terrain.position)


def test_footholds_are_those_on_our_map(deployed):
    selector = FootholdSelector.load("anymal_b")
    terrain = ElevationMap(make_course("rubble", 1, size=3.0).elevation, 0.02, np.array([0.2, 0.1]))
    arguments = as_grid_map(terrain, (5, 9)), 0.02, (0.2, 0.1), (5, 9), POSE
    found = deployed("grid_map").footholds_on_grid_map(selector, *arguments, legs=("LF", "RH"), top_k=2)
    assert found == selector.select(terrain, POSE, ("LF", "RH"), top_k=2)
    assert found["LF"].status == "ok"


def test_bad_arrays_are_told(deployed):
    module = deployed("grid_map")
    with pytest.raises(MapError, match=r"shape \(4,\)"):
        module.elevation_map_of(np.zeros(4), 0.02)
    with pytest.raises(MapError, match="start index"):
        module.elevation_map_of(np.zeros((4, 5)), 0.02, start_index=(0, 5))
