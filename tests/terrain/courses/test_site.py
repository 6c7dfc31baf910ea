import numpy as np
import pytest

from footsel.terrain.courses.site import Site, bounded_walk, lengths_to_cover


@pytest.mark.parametrize("wavelength", [0.1, 0.4, 1.0])
def test_noise_has_unit_variance_and_nothing_finer_than_its_wavelength(wavelength):
    site = Site(400, 0.02)
    noise = np.stack([site.noise(np.random.default_rng(seed), wavelength) for seed in range(8)])
    assert noise.std() == pytest.approx(1, abs=0.1)
    assert abs(noise.mean()) < 0.15
    power = np.abs(np.fft.rfft(noise * np.hanning(400), axis=2)) ** 2
    finer = np.fft.rfftfreq(400, site.resolution) > 2 / wavelength
    assert power[..., finer].sum() < 0.003 * power.sum()


def test_noise_does_not_depend_on_the_cell_size():
    fine, coarse = (Site(cells, 4 / cells).noise(np.random.default_rng(0), 0.5) for cells in (600, 200))
    np.testing.assert_allclose(fine[1::3, 1::3], coarse, atol=1e-9)


def test_a_stamp_raises_what_lies_below_it_and_nothing_else():
    site = Site(50, 0.1)
    heights = site.flat()
    heights[:, 25:] = 2.0
    site.stamp(heights, 0.33, 0.0, 0.5, lambda dx, dy: np.where(np.hypot(dx, dy) < 0.5, 1.0, np.nan))
    disc = np.hypot(site.x - 0.33, site.y) < 0.5
    np.testing.assert_array_equal(heights, np.where(site.y > 0, 2.0, np.where(disc, 1.0, 0.0)))


def test_a_stamp_may_reach_beyond_the_site():
    site = Site(20, 0.1)
    for x, y in [(0.95, -0.95), (5.0, 0.0), (-5.0, -5.0)]:
        heights = site.flat()
        site.stamp(heights, x, y, 0.3, lambda dx, dy: np.where(np.hypot(dx, dy) <= 0.3, 1.0, np.nan))
        np.testing.assert_array_equal(heights, np.hypot(site.x - x, site.y - y) <= 0.3)


def test_height_at_a_point_is_that_of_its_cell():
    site = Site(20, 0.1)
    heights = np.arange(400.0).reshape(20, 20)
    assert site.height_at(heights, -0.95, 0.95) == heights[0, 19]
    assert site.height_at(heights, 0.049, -0.01) == heights[10, 9]
    assert site.height_at(heights, -9, 9) == heights[0, 19]


def test_edges_cover_every_direction_of_the_site():
    site = Site(300, 0.02)
    for seed in range(50):
        edges = lengths_to_cover(np.random.default_rng(seed), 0.4, 1.1, site)
        assert edges[0] <= -site.reach
        assert edges[-2] < site.reach <= edges[-1]
        assert ((np.diff(edges) >= 0.4) & (np.diff(edges) <= 1.1)).all()


def test_a_walk_keeps_its_bounds_and_the_sizes_of_its_changes():
    changes = np.random.default_rng(0).uniform(-0.3, 0.3, 500)
    levels = bounded_walk(changes, 0.4)
    assert np.abs(levels).max() <= 0.4
    np.testing.assert_allclose(np.abs(np.diff(levels)), np.abs(changes))
