"""Rotations of the base and of its heading."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footsel.errors import InputError
from footsel.footholds import BasePose
from footsel.footholds.pose import heading_rotation, tilt_rotation

angle = st.floats(-3, 3)


def about(axis: int, angle: float) -> np.ndarray:
    """Rotation about one axis by Rodrigues' formula."""
    k = np.cross(np.eye(3), np.eye(3)[axis])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


@given(angle, angle, angle)
def test_rotation_is_yaw_after_pitch_after_roll(roll, pitch, yaw):
    expected = about(2, yaw) @ about(1, pitch) @ about(0, roll)
    np.testing.assert_allclose(BasePose(0, 0, 0, roll, pitch, yaw).rotation(), expected, atol=1e-12)
    np.testing.assert_allclose(heading_rotation(yaw), about(2, yaw), atol=1e-12)
    np.testing.assert_allclose(tilt_rotation(roll, pitch), about(1, pitch) @ about(0, roll), atol=1e-12)


def test_signs():
    """Yaw turns left, pitch puts the nose down, roll lifts the left side."""
    assert (heading_rotation(0.1) @ [1, 0, 0])[1] > 0
    assert (tilt_rotation(0, 0.1) @ [1, 0, 0])[2] < 0
    assert (tilt_rotation(0.1, 0) @ [0, 1, 0])[2] > 0


def test_of_accepts_six_numbers_in_any_form():
    pose = BasePose(1, 2, 3, 0.1, 0.2, 0.3)
    for form in (pose, pose.as_list(), tuple(pose.as_list()), np.array(pose.as_list()), np.array([pose.as_list()])):
        assert BasePose.of(form) == pose


@pytest.mark.parametrize(
    "form", [(1, 2, 3), [0] * 7, [0, 0, 0, 0, 0, np.nan], [np.inf, 0, 0, 0, 0, 0], "pose", [[1], [1, 2]], None]
)
def test_of_refuses_everything_else(form):
    with pytest.raises(InputError, match="x y z roll pitch yaw"):
        BasePose.of(form)
