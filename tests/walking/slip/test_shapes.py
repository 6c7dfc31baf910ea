"""Courses of shapes hold what they are for: pits that a foot bridges, spikes, steps and level ground, evenly many."""

import numpy as np

from footsel.walking.slip.shapes import SIZES, TILE, shape_course


def test_same_seed_same_course_and_no_other():
    first, again, other = (shape_course(seed).elevation for seed in (5, 5, 6))
    assert first.tobytes() == again.tobytes() and first.shape == (150, 150)
    assert not np.array_equal(first, other)


def test_tiles_are_pits_as_often_as_spikes_and_some_are_bare():
    course = shape_course(0, size=12.0).elevation.astype(np.float64)
    side = len(course) // TILE
    tiles = course[: side * TILE, : side * TILE].reshape(side, TILE, side, TILE).swapaxes(1, 2).reshape(-1, TILE, TILE)
    # What is left of a tile without its plane.
    along = np.arange(TILE) - (TILE - 1) / 2
    x, y = np.meshgrid(along, along, indexing="ij")
    slope_x, slope_y = (np.einsum("nij,ij->n", tiles, axis) / (axis**2).sum() for axis in (x, y))
    rest = tiles - slope_x[:, None, None] * x - slope_y[:, None, None] * y
    rest -= np.median(rest, axis=(1, 2), keepdims=True)
    bare = np.ptp(rest, axis=(1, 2)) < 1e-6
    assert 0.1 < bare.mean() < 0.25
    spot = rest[:, TILE // 2, TILE // 2]
    pits, spikes = (spot < -SIZES[0]).sum(), (spot > SIZES[0]).sum()
    assert 0.7 < pits / spikes < 1.4
    assert np.abs(course).max() > SIZES[1] / 2
