import numpy as np

from footsel.terrain.codec import HEIGHT_RANGE, heights_to_image, image_to_heights, quantise_image


def test_depths_within_the_range_come_back():
    heights = np.linspace(-HEIGHT_RANGE, 0, 1000)
    np.testing.assert_allclose(image_to_heights(heights_to_image(heights)), heights, atol=1e-6)


def test_what_lies_beyond_the_range_is_clipped_and_unknown_is_farthest():
    assert heights_to_image([0.2, 0.0, -0.85, -2.0, np.nan]).tolist() == [0.0, 0.0, 1.0, 1.0, 1.0]


def test_deeper_is_brighter():
    assert (np.diff(heights_to_image(np.linspace(0, -0.85, 500))) > 0).all()


def test_eight_bits_hold_heights_to_half_a_step():
    heights = np.linspace(-HEIGHT_RANGE, 0, 5000)
    grey = quantise_image(heights_to_image(heights))
    assert grey.dtype == np.uint8
    assert set(grey.tolist()) == set(range(256))
    error = np.abs(image_to_heights(grey / 255) - heights)
    assert error.max() <= HEIGHT_RANGE / 255 / 2 + 1e-6
    assert quantise_image(heights_to_image([np.nan])).tolist() == [255]


def test_a_range_scaled_with_the_robot_gives_the_same_image():
    heights = np.random.default_rng(0).uniform(-1, 0.1, (3, 40, 40))
    np.testing.assert_allclose(
        heights_to_image(heights * 0.4, HEIGHT_RANGE * 0.4), heights_to_image(heights), atol=1e-6
    )
