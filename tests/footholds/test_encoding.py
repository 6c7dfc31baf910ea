"""What a network sees."""

import json

import numpy as np
import pytest

from footsel.errors import InputError
from footsel.footholds.encoding import PLANES, TILT_RANGE, InputEncoding


@pytest.fixture
def heights():
    heights = np.random.default_rng(0).uniform(-1.0, 0.2, (3, 40, 40)).astype(np.float32)
    heights[:, 5:8, 30:] = np.nan
    return heights


def test_planes_come_in_their_order(heights):
    roll, pitch = np.array([0.1, 0.0, -0.2]), np.array([0.0, 0.05, 0.1])
    for planes in (("height",), ("pitch", "height"), PLANES):
        encoded = InputEncoding(planes, quantised=False).encode(heights, roll, pitch)
        assert encoded.shape == (3, len(planes), 40, 40)
        assert encoded.dtype == np.float32
        for index, plane in enumerate(planes):
            alone = InputEncoding((plane,), quantised=False).encode(heights, roll, pitch)
            np.testing.assert_array_equal(encoded[:, index], alone[:, 0])


def test_the_depth_image_cell_by_cell(heights):
    encoded = InputEncoding(("height",), quantised=False, height_range=0.85).encode(heights)
    for n, i, j in [(0, 0, 0), (1, 20, 3), (2, 39, 39), (0, 6, 35)]:
        z = heights[n, i, j]
        expected = 1.0 if np.isnan(z) else min(max(-float(z) / 0.85, 0.0), 1.0)
        assert encoded[n, 0, i, j] == pytest.approx(expected, abs=1e-6)


def test_what_rises_above_the_hip_is_no_part_of_the_depth_image(heights):
    depth, above = InputEncoding(("height", "above"), quantised=False, height_range=0.85).encode(heights).swapaxes(0, 1)
    known = ~np.isnan(heights)
    assert (heights[known] > 0).any()
    np.testing.assert_allclose((above - depth)[known] * 0.85, np.maximum(heights[known], -0.85), atol=1e-6)
    assert not (depth * above).any()
    assert (above[~known] == 0).all()
    tower = InputEncoding(("above",), quantised=False, height_range=0.85).encode(np.full((1, 40, 40), 9.0))
    assert (tower == 1).all()


def test_the_paper_s_image_has_256_steps(heights):
    smooth, stepped = (InputEncoding(("height",), quantised=q).encode(heights) for q in (False, True))
    np.testing.assert_allclose(stepped * 255, np.rint(stepped * 255), atol=1e-4)
    assert 0 < np.abs(stepped - smooth).max() <= 0.5 / 255 + 1e-6


def test_unknown_cells_are_marked(heights):
    unknown = InputEncoding(("unknown",)).encode(heights)[:, 0]
    np.testing.assert_array_equal(unknown == 1, np.isnan(heights))
    assert set(np.unique(unknown)) == {0, 1}


def test_tilt_is_one_at_its_range(heights):
    encoding = InputEncoding(("roll", "pitch"))
    encoded = encoding.encode(heights, TILT_RANGE, [-TILT_RANGE, 0, TILT_RANGE / 2])
    np.testing.assert_allclose(encoded[:, 0], 1, rtol=1e-6)
    np.testing.assert_allclose(encoded[:, 1, 0, 0], [-1, 0, 0.5], rtol=1e-6)


def test_an_encoding_survives_json():
    encoding = InputEncoding(("height", "roll"), quantised=False, height_range=0.6)
    assert InputEncoding.from_dict(json.loads(json.dumps(encoding.to_dict()))) == encoding


@pytest.mark.parametrize("planes", [(), ("colour",), ("height", "yaw")])
def test_unknown_planes_are_refused(planes):
    with pytest.raises(InputError, match="choose from: height, unknown, roll, pitch, above"):
        InputEncoding(planes)
