"""Where a lowered ball first touches: against a ball laid on points of the surface, and against geometry."""

import numpy as np
import pytest

from footsel.walking.slip.touchdown import touchdown_heights

RADIUS, CELL = 0.031, 0.02


def on_points(heights: np.ndarray, resolution: float, radius: float, xy: np.ndarray, points: int = 401) -> float:
    """The centre of a ball at xy that rests on the highest of many points of the triangulated surface under it."""
    along = np.linspace(-radius, radius, points)
    dx, dy = np.meshgrid(along, along, indexing="ij")
    under = dx**2 + dy**2 <= radius**2
    dx, dy = dx[under], dy[under]
    u, v = ((c + d) / resolution + (n - 1) / 2 for c, d, n in zip(xy, (dx, dy), heights.shape, strict=True))
    i, j = np.floor(u).astype(int), np.floor(v).astype(int)
    u, v = u - i, v - j
    near = heights[i, j] + u * (heights[i + 1, j] - heights[i, j]) + v * (heights[i, j + 1] - heights[i, j])
    far = heights[i + 1, j + 1]
    beyond = far + (1 - u) * (heights[i, j + 1] - far) + (1 - v) * (heights[i + 1, j] - far)
    surface = np.where(u + v <= 1, near, beyond)
    return float((surface + np.sqrt(radius**2 - dx**2 - dy**2)).max())


@pytest.mark.parametrize("roughness", [0.002, 0.01, 0.05])
@pytest.mark.parametrize("resolution", [0.01, 0.02, 0.04])
def test_equals_a_ball_laid_on_many_points(roughness, resolution):
    """Points miss the very top of a ridge, so they are never higher and, this close together, hardly lower."""
    rng = np.random.default_rng(0)
    # The same slope of the triangles at any cell size, and another number of rows than of columns.
    heights = rng.normal(0, roughness * resolution / CELL, (31, 25))
    xy = rng.uniform(-0.06, 0.06, (40, 2))
    found = touchdown_heights(heights, resolution, RADIUS, xy)
    expected = np.array([on_points(heights, resolution, RADIUS, place) for place in xy])
    assert (found >= expected - 1e-12).all()
    assert (found - expected).max() < 1e-3 * roughness / 0.01


@pytest.mark.parametrize("direction", np.linspace(0, 2 * np.pi, 9))
def test_a_plane_is_touched_a_radius_away_from_it(direction):
    slope = 0.8
    along = (np.arange(21) - 10) * CELL
    x, y = np.meshgrid(along, along, indexing="ij")
    gradient = slope * np.array([np.cos(direction), np.sin(direction)])
    xy = np.random.default_rng(1).uniform(-0.1, 0.1, (50, 2))
    centres = touchdown_heights(gradient[0] * x + gradient[1] * y + 0.3, CELL, RADIUS, xy)
    np.testing.assert_allclose(centres, xy @ gradient + 0.3 + RADIUS * np.hypot(1, slope), atol=1e-12)


def test_a_spike_is_met_by_the_ball_s_side():
    heights = np.zeros((21, 21))
    heights[10, 10] = 1.0
    offsets = np.array([0.0, 0.01, 0.02, 0.03])
    centres = touchdown_heights(heights, CELL, RADIUS, np.column_stack([offsets, 0 * offsets]))
    np.testing.assert_allclose(centres[:2], 1 + np.sqrt(RADIUS**2 - offsets[:2] ** 2))
    # Further out the steep side of the spike touches first, lower down than the tip.
    assert (np.diff(centres) < 0).all() and centres[3] > 0.1


def test_the_diagonal_runs_from_one_row_on_to_one_column_on():
    """On the saddle's raised diagonal the ball rests on a ridge of full height; across it the other saddle sags."""
    saddle = np.zeros((12, 12))
    saddle[6, 5] = saddle[5, 6] = 0.01
    middle = np.zeros((1, 2))  # Half way between cells 5 and 6.
    raised = touchdown_heights(saddle, CELL, RADIUS, middle)[0]
    sunken = touchdown_heights(saddle[::-1], CELL, RADIUS, middle)[0]
    assert raised == pytest.approx(0.01 + RADIUS)
    assert sunken < 0.01 + RADIUS - 1e-4


def test_a_wider_ball_touches_no_lower_part():
    """The lowest point of a wider ball is higher: it is held up by more ground."""
    heights = np.random.default_rng(2).normal(0, 0.03, (31, 31))
    xy = np.random.default_rng(3).uniform(-0.1, 0.1, (60, 2))
    lowest = [touchdown_heights(heights, CELL, radius, xy) - radius for radius in (0.01, 0.02, 0.031, 0.05)]
    assert (np.diff(lowest, axis=0) >= -1e-12).all()
