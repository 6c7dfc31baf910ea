"""Laws of the camera, of capsules in its view, and what it refuses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footsel.errors import InputError
from footsel.mapping import CameraModel, Capsule, FittedNoise, StereoNoise
from footsel.mapping.capsule import without_bodies

CAMERA = CameraModel(24, 16, 12.0, 13.0, 11.0, 8.5, FittedNoise(), 0.2, 3.0)
number = st.floats(-1.5, 1.5)
point = st.tuples(number, number, number)


def test_a_point_on_the_ray_of_a_pixel_is_seen_in_that_pixel():
    depth = np.random.default_rng(0).uniform(0.3, 3, 24 * 16)
    pixels, z = CAMERA.project(CAMERA.rays.T * depth[:, None])
    v, u = np.indices((16, 24))
    assert np.allclose(pixels.reshape(16, 24, 2), np.stack([u, v], axis=-1), atol=1e-4)
    assert np.allclose(z, depth)


def test_what_is_behind_the_camera_is_in_no_pixel():
    pixels, _ = CAMERA.project(np.array([[0.1, 0.1, -1.0], [0.0, 0.0, 0.0]]))
    assert np.isnan(pixels).all()


def test_readings_are_what_a_number_in_range_is():
    depth = np.full((16, 24), 1.0)
    depth[0, :7] = np.nan, np.inf, -np.inf, -1.0, 0.0, 0.19, 3.01
    readings = CAMERA.readings(depth)
    assert not readings[0, :7].any()
    assert (readings.reshape(-1)[7:] == 1).all()


@pytest.mark.parametrize("depth", [np.ones((24, 16)), np.ones(384), "far", [[1.0, None]], 1.0])
def test_what_is_no_depth_image_is_refused(depth):
    with pytest.raises(InputError, match="depth image"):
        CAMERA.readings(depth)


@pytest.mark.parametrize(
    "changes",
    [
        {"width": 0},
        {"height": -1},
        {"shared_px": 0},
        {"fx": 0.0},
        {"fy": np.nan},
        {"cx": np.inf},
        {"nearest": -0.1},
        {"nearest": 2.0, "farthest": 2.0},
        {"farthest": np.nan},
    ],
)
def test_a_camera_that_cannot_be_is_refused(changes):
    values = {"width": 4, "height": 4, "fx": 2.0, "fy": 2.0, "cx": 1.5, "cy": 1.5, "noise": FittedNoise()}
    with pytest.raises(InputError, match="expected"):
        CameraModel(**{**values, **changes})


def test_published_noise_and_that_of_stereo_agree_within_two_times():
    depth = np.linspace(0.8, 3.25, 50)
    focal = 848 / (2 * np.tan(np.deg2rad(87) / 2))
    stereo, fitted = StereoNoise(0.08, focal, 0.05).sigma(depth), FittedNoise().sigma(depth)
    assert (stereo / fitted > 1).all() and (stereo / fitted < 2).all()
    assert np.isclose(StereoNoise(0.08, focal, 0.05).sigma(np.array(1.0)), 3.6e-3, atol=1e-4)


@given(point, point, st.floats(0, 0.8), st.integers(0, 2**32 - 1))
@settings(max_examples=150, deadline=None)
def test_readings_in_a_body_are_left_out_wherever_it_is(start, end, radius, seed):
    body = Capsule(np.array(start), np.array(end), radius)
    depth = np.random.default_rng(seed).uniform(0, 2, (16, 24)).astype(np.float32)
    left = without_bodies(depth, CAMERA, [body])
    # The same point by point, by the distance to many points of the capsule's axis.
    along = np.linspace(0, 1, 201)[:, None]
    axis = body.start + along * (body.end - body.start)
    points = CAMERA.rays.T * depth.reshape(-1)[:, None]
    distance = np.linalg.norm(points[:, None] - axis, axis=-1).min(axis=1).reshape(16, 24)
    spacing = np.linalg.norm(body.end - body.start) / 200
    assert not left[distance < radius - 1e-6].any()
    outside = distance > np.hypot(radius, spacing) + 1e-6
    assert (left[outside] == depth[outside]).all()


@pytest.mark.parametrize("changes", [{"start": [0, 0]}, {"end": [0, np.nan, 0]}, {"radius": -1.0}, {"radius": np.nan}])
def test_a_capsule_that_cannot_be_is_refused(changes):
    with pytest.raises(InputError, match="capsule"):
        Capsule(**{"start": [0, 0, 0], "end": [0, 0, 1], "radius": 0.1, **changes})
