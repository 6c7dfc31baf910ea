import numpy as np
import pytest
from PIL import Image

from footsel import ElevationMap
from footsel.errors import MapError

OPTIONS = {"resolution": 0.05, "png_range": (-0.5, 1.0)}


@pytest.mark.parametrize(("dtype", "white"), [(np.uint8, 255), (np.uint16, 65535)])
def test_grey_is_height_between_black_and_white(tmp_path, dtype, white):
    grey = np.random.default_rng(0).integers(0, white + 1, (6, 8)).astype(dtype)
    grey[0, 0], grey[5, 7] = 0, white
    Image.fromarray(grey).save(tmp_path / "map.png")
    terrain = ElevationMap.load(tmp_path / "map.png", **OPTIONS)
    assert terrain.resolution == 0.05
    for row in range(6):
        for column in range(8):
            height = terrain.elevation[5 - row, 7 - column]
            assert height == pytest.approx(-0.5 + 1.5 * grey[row, column] / white, abs=1e-6)


def test_top_row_is_ahead_and_left_column_is_left(tmp_path):
    grey = np.zeros((4, 6), dtype=np.uint8)
    grey[0, 0] = 255
    Image.fromarray(grey).save(tmp_path / "map.png")
    terrain = ElevationMap.load(tmp_path / "map.png", **OPTIONS)
    assert terrain.sample([terrain.x().max(), terrain.y().max()]) == 1.0
    assert (terrain.elevation == 1.0).sum() == 1


def test_black_is_low_or_unknown(tmp_path):
    grey = np.array([[0, 10], [0, 20]], dtype=np.uint8)
    Image.fromarray(grey).save(tmp_path / "map.png")
    assert ElevationMap.load(tmp_path / "map.png", **OPTIONS).elevation.min() == -0.5
    unknown = ElevationMap.load(tmp_path / "map.png", png_zero_unknown=True, **OPTIONS)
    assert unknown.known.tolist() == [[True, False], [True, False]]


def test_transparent_pixels_are_unknown(tmp_path):
    pixels = np.full((3, 3, 4), 100, dtype=np.uint8)
    pixels[..., 3] = 255
    pixels[0, 2, 3] = 0
    Image.fromarray(pixels).save(tmp_path / "map.png")
    terrain = ElevationMap.load(tmp_path / "map.png", **OPTIONS)
    assert (~terrain.known).sum() == 1
    assert not terrain.known[2, 0]


def test_colour_is_refused(tmp_path):
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (4, 4, 3)).astype(np.uint8)).save(tmp_path / "map.png")
    with pytest.raises(MapError, match=r"map\.png.*colour"):
        ElevationMap.load(tmp_path / "map.png", **OPTIONS)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"resolution": 0.02}, "--png-range"),
        ({"png_range": (0, 1)}, "--resolution"),
        ({"resolution": 0.02, "png_range": (1, 0)}, r"\(1, 0\)"),
        ({"resolution": 0.02, "png_range": (0, np.inf)}, "inf"),
        ({"resolution": 0.02, "png_range": (0, 1, 2)}, "LOW below HIGH"),
        ({"resolution": 0.0, "png_range": (0, 1)}, "resolution is 0.0"),
    ],
)
def test_options_that_are_missing_or_wrong_are_named(tmp_path, options, named):
    Image.fromarray(np.zeros((4, 4), dtype=np.uint8)).save(tmp_path / "map.png")
    with pytest.raises(MapError, match=named):
        ElevationMap.load(tmp_path / "map.png", **options)
