import numpy as np
import pytest

from footsel import ElevationMap
from footsel.errors import MapError


def random_map(seed, shape=(23, 31), resolution=0.03, holes=0.2):
    rng = np.random.default_rng(seed)
    elevation = rng.uniform(-1, 1, shape)
    elevation[rng.random(shape) < holes] = np.nan
    return ElevationMap(elevation, resolution, rng.uniform(-2, 2, 2))


def sample_one(elevation_map, x, y):
    """Weigh the four cells around a point by hand; unknown exactly where the nearest cell is unknown or missing."""
    xs, ys = elevation_map.x(), elevation_map.y()
    half = elevation_map.resolution / 2
    if not (xs[0] - half <= x < xs[-1] + half and ys[0] - half <= y < ys[-1] + half):
        return np.nan
    if np.isnan(elevation_map.elevation[np.abs(xs - x).argmin(), np.abs(ys - y).argmin()]):
        return np.nan
    x, y = np.clip(x, xs[0], xs[-1]), np.clip(y, ys[0], ys[-1])
    total = weights = 0.0
    for i, cell_x in enumerate(xs):
        for j, cell_y in enumerate(ys):
            weight = max(0, 1 - abs(x - cell_x) / (2 * half)) * max(0, 1 - abs(y - cell_y) / (2 * half))
            if weight > 0 and not np.isnan(elevation_map.elevation[i, j]):
                total += weight * elevation_map.elevation[i, j]
                weights += weight
    return total / weights


def test_sample_equals_bilinear_weights_by_hand():
    elevation_map = random_map(0)
    rng = np.random.default_rng(1)
    points = elevation_map.position + rng.uniform(-0.55, 0.55, (400, 2)) * elevation_map.size
    expected = [sample_one(elevation_map, x, y) for x, y in points]
    assert np.isnan(expected).any()
    np.testing.assert_allclose(elevation_map.sample(points), expected, atol=1e-6)


def test_cell_centres_give_the_cells_themselves():
    elevation_map = random_map(2)
    centres = np.stack(np.meshgrid(elevation_map.x(), elevation_map.y(), indexing="ij"), axis=-1)
    np.testing.assert_allclose(elevation_map.sample(centres), elevation_map.elevation, atol=1e-6)


def test_i_grows_along_x_and_j_along_y():
    elevation = np.zeros((4, 6))
    elevation[3, 0] = 1.0
    elevation_map = ElevationMap(elevation, 0.5, np.array([10.0, 20.0]))
    assert elevation_map.sample([10.75, 18.75]) == 1.0
    assert elevation_map.size == (2.0, 3.0)


@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.4, -0.3), (30.0, 0.0)])
def test_window_is_the_part_of_the_map_around_the_nearest_cell(offset):
    elevation_map = random_map(3)
    centre = elevation_map.position + offset
    window = elevation_map.window(centre, 9)
    middle = window.position
    nearest = np.floor(elevation_map.fractional_index(centre) + 0.5)
    np.testing.assert_allclose(elevation_map.fractional_index(middle), nearest, atol=1e-9)
    points = np.stack(np.meshgrid(window.x(), window.y(), indexing="ij"), axis=-1)
    np.testing.assert_allclose(window.elevation, elevation_map.sample(points), atol=1e-5)
    assert window.known.any() == (offset[0] < 1)


def test_contains_ends_at_the_borders_of_the_outer_cells():
    elevation_map = ElevationMap(np.full((4, 6), np.nan), 0.1)
    inside = elevation_map.contains([[0.199, 0.299], [-0.199, -0.299], [0.201, 0.0], [0.0, 0.301], [0.0, -0.301]])
    assert inside.tolist() == [True, True, False, False, False]


@pytest.mark.parametrize(
    ("elevation", "resolution", "position", "named"),
    [
        (np.zeros(5), 0.1, (0, 0), r"\(5,\)"),
        (np.zeros((1, 5)), 0.1, (0, 0), "2x2"),
        (np.full((3, 3), np.inf), 0.1, (0, 0), "NaN"),
        (np.full((3, 3), 1e300), 0.1, (0, 0), "infinite"),
        (np.zeros((3, 3)), 0.0, (0, 0), "0.0"),
        (np.zeros((3, 3)), -0.02, (0, 0), "-0.02"),
        (np.zeros((3, 3)), np.nan, (0, 0), "nan"),
        (np.zeros((3, 3)), 0.1, (0, 0, 0), "two finite numbers"),
        (np.zeros((3, 3)), 0.1, (0, np.nan), "two finite numbers"),
        (np.full((3, 3), "a"), 0.1, (0, 0), "not numeric"),
    ],
)
def test_maps_that_make_no_sense_are_refused(elevation, resolution, position, named):
    with pytest.raises(MapError, match=named):
        ElevationMap(elevation, resolution, np.array(position))
