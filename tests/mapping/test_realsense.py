"""The simulated D435 does to a depth image what is known of the camera, and nothing else."""

import numpy as np
import pytest

from footsel.errors import InputError
from footsel.mapping import D435
from footsel.mapping.realsense import BASELINE, DEPTH_STEP, DISPARITY_STEP, FOCAL_PX, SUBPIXEL

SENSOR = D435(212, 120)


def read(depth, seed=0, sensor=SENSOR):
    return sensor.read(depth, np.random.default_rng(seed))


def wall(depth):
    return np.full((120, 212), depth)


@pytest.mark.parametrize("depth", [0.6, 1.0, 2.0, 3.0])
def test_a_wall_is_read_with_the_noise_of_the_formula(depth):
    readings = np.stack([read(wall(depth), seed) for seed in range(8)])
    error = readings[readings > 0] - depth
    sigma = SENSOR.camera.noise.sigma(np.array(depth))
    assert np.isclose(sigma, depth**2 * SUBPIXEL / (FOCAL_PX * BASELINE))
    # Steps of disparity and of depth add the variance of a uniform error.
    step = depth**2 * DISPARITY_STEP / (FOCAL_PX * BASELINE)
    assert np.isclose(error.std(), np.sqrt(sigma**2 + (step**2 + DEPTH_STEP**2) / 12), rtol=0.03)
    assert abs(error.mean()) < 0.02 * sigma + DEPTH_STEP / 2


def test_a_slanted_plane_stays_a_plane(worlds):
    """Fraying must not turn a slope into noise: only edges fray."""
    depth = worlds.Scene().depth(SENSOR.camera, worlds.placement(0, 0, 0.5))
    readings = read(depth)
    seen = readings > 0
    error = (readings[seen] - depth[seen]) / SENSOR.camera.noise.sigma(depth[seen])
    assert abs(error.mean()) < 0.05 and 0.9 < error.std() < 1.15


def test_an_edge_frays_by_a_few_pixels():
    depth = wall(1.5)
    depth[:60] = 1.0
    near = np.mean([read(depth, seed) < 1.2 for seed in range(20)], axis=(0, 2))
    assert near[:48].min() > 0.999 and near[72:].max() < 0.001
    assert 0.02 < near[60] < 0.5 and near[60] > near[63] > near[66]


def test_what_only_the_left_imager_sees_has_no_depth():
    near, far, first, last = 0.7, 1.4, 80, 130
    depth = wall(far)
    depth[:, first:last] = near
    lost = np.mean([read(depth, seed) == 0 for seed in range(10)], axis=(0, 1))
    # The shadow lies left of the obstacle and is as wide as the disparities differ.
    shadow = FOCAL_PX * BASELINE * (1 / near - 1 / far) / 4
    assert shadow > 3
    assert lost[: first - int(np.ceil(shadow)) - 1].max() == 0
    assert lost[first - int(shadow) + 1 : first - 1].min() == 1
    assert lost[first:].max() == 0


def test_what_is_out_of_range_has_no_depth():
    assert not read(wall(0.25)).any()
    assert not read(wall(3.5)).any()
    assert not read(wall(np.inf)).any()


def test_any_width_sees_the_same_view():
    narrow, wide = D435(106, 60).camera, D435(424, 240).camera
    assert np.isclose(narrow.width / narrow.fx, wide.width / wide.fx)
    assert np.isclose(2 * np.arctan(wide.width / wide.fx / 2), np.deg2rad(87))


def test_the_same_seed_gives_the_same_image():
    assert (read(wall(1.0), 3) == read(wall(1.0), 3)).all()
    assert (read(wall(1.0), 3) != read(wall(1.0), 4)).any()


def test_other_shapes_are_refused():
    with pytest.raises(InputError, match=r"expected \(120, 212\)"):
        read(np.ones((212, 120)))
    with pytest.raises(InputError, match="2x2"):
        D435(1, 120)
