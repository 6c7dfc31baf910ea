"""What a map misses between known cells counts as high as they are; what it does not know at all stays unknown."""

import numpy as np
import pytest

from footsel.terrain import ElevationMap
from footsel.walking.gait.narrow_holes import NARROW, without_narrow_holes

MIDDLE = 30


def seam(cells, resolution=0.02):
    """A block beside the ground, and so many unknown rows between."""
    heights = np.zeros((60, 40), dtype=np.float32)
    heights[:MIDDLE] = 0.2
    heights[MIDDLE : MIDDLE + cells] = np.nan
    return ElevationMap(heights, resolution)


def test_a_map_without_holes_is_itself():
    whole = seam(0)
    assert without_narrow_holes(whole) is whole


@pytest.mark.parametrize("resolution", [0.01, 0.02, 0.04])
def test_a_seam_beside_a_block_is_no_lower_than_the_block_as_far_as_it_may_reach(resolution):
    cells = round(NARROW / resolution / 2)
    filled = without_narrow_holes(seam(cells, resolution))
    assert filled.known.all() and filled.elevation[MIDDLE, 10] == np.float32(0.2)
    # Nothing else changes.
    known = seam(cells, resolution).known
    np.testing.assert_array_equal(filled.elevation[known], seam(cells, resolution).elevation[known])


def test_wide_holes_and_what_lies_beyond_the_ground_stay_unknown():
    wide = seam(round(NARROW / 0.02) + 1)
    assert (without_narrow_holes(wide).known == wide.known).all()
    edge = np.zeros((60, 40), dtype=np.float32)
    edge[:, 20:] = np.nan
    assert (without_narrow_holes(ElevationMap(edge, 0.02)).known == ~np.isnan(edge)).all()


def test_a_map_that_knows_nothing_stays_so():
    assert not without_narrow_holes(ElevationMap(np.full((30, 30), np.nan), 0.02)).known.any()
