"""Features of windows against cell-by-cell references."""

import numpy as np
import pytest

from footsel.selectors.classic.neighbourhood import Neighbourhood, disc, shifted

CELLS = 12


@pytest.fixture(params=[0.01, 0.02, 0.04])
def resolution(request):
    return request.param


@pytest.fixture
def heights():
    rng = np.random.default_rng(5)
    return np.where(rng.random((CELLS, CELLS)) < 0.2, np.nan, rng.normal(0.0, 0.05, (CELLS, CELLS)) - 0.5)


def window(heights, cell, radius, resolution):
    """(m, 3) x, y, z of the known cells within `radius` of a cell, relative to it."""
    points = [
        ((i - cell[0]) * resolution, (j - cell[1]) * resolution, heights[i, j] - heights[cell])
        for i, j in np.ndindex(heights.shape)
        if np.hypot(i - cell[0], j - cell[1]) * resolution <= radius + 1e-9 and not np.isnan(heights[i, j])
    ]
    return np.array(points)


def test_features_are_those_of_each_window(heights, resolution):
    radius = 0.055
    around = Neighbourhood(heights, radius, resolution)
    plane = around.plane()
    curvature = around.curvature(plane)
    compared = 0
    for cell in zip(*np.nonzero(~np.isnan(heights)), strict=True):
        x, y, z = window(heights, cell, radius, resolution).T
        assert around.highest()[cell] == pytest.approx(z.max())
        assert around.lowest()[cell] == pytest.approx(z.min())
        assert around.mean()[cell] == pytest.approx(z.mean())
        assert around.deviation()[cell] == pytest.approx(z.std())
        design = np.stack([np.ones_like(x), x, y, x * x + y * y], axis=1)
        if np.linalg.matrix_rank(design[:, :3] / [1, resolution, resolution]) == 3:
            (_, *gradient), *_ = np.linalg.lstsq(design[:, :3], z, rcond=None)
            np.testing.assert_allclose(plane.gradient[(slice(None), *cell)], gradient, atol=1e-8)
            off = z - design[:, :3] @ np.linalg.lstsq(design[:, :3], z, rcond=None)[0]
            normal = off / np.sqrt(1 + gradient[0] ** 2 + gradient[1] ** 2)
            assert plane.roughness[cell] == pytest.approx(np.sqrt((normal**2).sum() / (len(z) - 1)))
        else:
            assert np.isnan(plane.gradient[(slice(None), *cell)]).all()
        if np.linalg.matrix_rank(design / [1, resolution, resolution, resolution**2]) == 4:
            c = np.linalg.lstsq(design, z, rcond=None)[0][3]
            assert curvature[cell] == pytest.approx(2 * c, rel=1e-6)
            compared += 1
    assert compared > 40


def test_curvature_has_a_sign_and_a_unit(resolution):
    """A bowl of 20 cm radius curves by 5 per metre, whatever the cell and the slope under it."""
    along = (np.arange(40) - 19.5) * resolution
    x, y = np.meshgrid(along, along, indexing="ij")
    around = Neighbourhood((x**2 + y**2) / (2 * 0.2) + 0.3 * x, 0.08, resolution)
    inner = around.curvature(around.plane())[10:-10, 10:-10]
    np.testing.assert_allclose(inner, 5.0, atol=1e-6)


def test_directions_are_the_means_of_eight_wedges(heights):
    around = Neighbourhood(heights, 0.07, 0.02)
    directions = around.directions(around.rise)
    for cell in zip(*np.nonzero(~np.isnan(heights)), strict=True):
        x, y, z = window(heights, cell, 0.07, 0.02).T
        degrees = np.rad2deg(np.arctan2(y, x))
        for wedge in range(8):
            off = (degrees - 45 * wedge + 180) % 360 - 180
            inside = (np.abs(off) < 22.5) & ((x != 0) | (y != 0))
            expected = z[inside].mean() if inside.any() else np.nan
            assert directions[(wedge, *cell)] == pytest.approx(expected, nan_ok=True)


def test_what_lies_beyond_the_map_is_not_unknown_ground():
    flat = np.zeros((CELLS, CELLS))
    assert (Neighbourhood(flat, 0.06, 0.02).known_share() == 1.0).all()
    flat[5, 5] = np.nan
    share = Neighbourhood(flat, 0.06, 0.02).known_share()
    assert share[5, 6] == pytest.approx(28 / 29) and share[0, 0] == 1.0


def test_a_window_holds_the_nearest_cells_however_coarse_they_are():
    assert len(disc(0.05, 0.5)) == 5
    assert len(disc(0.05, 0.02)) == 21


def test_shifted_looks_the_way_of_its_steps():
    values = np.arange(9.0).reshape(3, 3)
    towards = shifted(values, np.array([[1, 0]]))[0]
    np.testing.assert_array_equal(towards[:2], values[1:])
    assert np.isnan(towards[2]).all()
