"""Where legs sit in the world."""

import json
from dataclasses import replace

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.errors import InputError
from footsel.footholds import BasePose, LegLayout
from footsel.legs import LEGS, mirror_of

POSE = BasePose(0.4, -0.3, 0.5, 0.1, -0.05, 1.1)


def plane(a: float, b: float, n: int = 150) -> ElevationMap:
    """z = a x + b y."""
    x = (np.arange(n) - (n - 1) / 2) * 0.02
    return ElevationMap(a * x[:, None] + b * x[None, :], 0.02)


def test_hips_move_with_the_whole_base(anymal_layout):
    for leg in LEGS:
        expected = POSE.position + POSE.rotation() @ anymal_layout.hips[leg]
        np.testing.assert_allclose(anymal_layout.hip_position(leg, POSE), expected)


def test_nominal_feet_turn_with_the_yaw_only(anymal_layout):
    level = replace(POSE, roll=0.0, pitch=0.0)
    for leg in LEGS:
        np.testing.assert_allclose(anymal_layout.nominal_xy(leg, POSE), anymal_layout.nominal_xy(leg, level))
        offset = anymal_layout.nominal_xy(leg, POSE) - POSE.position[:2]
        assert np.linalg.norm(offset) == pytest.approx(np.linalg.norm(anymal_layout.nominal_feet[leg][:2]))
    facing_left = BasePose(0, 0, 0.5, yaw=np.pi / 2)
    np.testing.assert_allclose(anymal_layout.nominal_xy("LF", facing_left), [-0.246, 0.36], atol=1e-12)


def test_mirrored_legs_stand_mirrored(anymal_layout):
    there = BasePose(POSE.x, -POSE.y, POSE.z, -POSE.roll, POSE.pitch, -POSE.yaw)
    for leg in LEGS:
        np.testing.assert_allclose(
            anymal_layout.hip_position(leg, POSE) * (1, -1, 1), anymal_layout.hip_position(mirror_of(leg), there)
        )


def test_the_nominal_foothold_stands_on_the_terrain(anymal_layout):
    x, y, z = anymal_layout.nominal_position("LF", POSE, plane(0.2, -0.1), np.array([0.31, 0.22]))
    assert (x, y) == (0.31, 0.22)
    assert z == pytest.approx(0.2 * x - 0.1 * y, abs=1e-6)


def test_over_unknown_ground_it_stands_where_a_level_base_would_put_it(anymal_layout):
    unknown = ElevationMap(np.full((50, 50), np.nan), 0.02)
    assert anymal_layout.nominal_position("LF", POSE, unknown, np.zeros(2))[2] == pytest.approx(0.5 - 0.47)


def test_local_map_is_the_terrain_below_the_hip(anymal_layout):
    a, b = 0.2, -0.1
    local = anymal_layout.local_map(plane(a, b), BasePose(0.1, 0.2, 0.5, 0.1, 0, 0.4), "RF")
    positions = local.positions()
    assert local.known.all()
    np.testing.assert_allclose(positions[..., 2], a * positions[..., 0] + b * positions[..., 1], atol=1e-6)
    np.testing.assert_allclose(positions[..., :2].mean(axis=(0, 1)), local.hip[:2], atol=1e-9)


def test_ground_height_is_that_below_the_feet(anymal_layout):
    assert anymal_layout.standing_height == pytest.approx(0.47)
    assert anymal_layout.ground_height(plane(0.1, 0.2), 0.3, -0.2, 0.8) == pytest.approx(0.03 - 0.04, abs=1e-3)
    # A tower beside the feet is not under them, whatever the heading.
    tower = plane(0, 0)
    tower.elevation[75 + 30 :, :] = 5.0
    assert anymal_layout.ground_height(tower, 0.0, 0.0, 0.0) == 0
    assert anymal_layout.ground_height(tower, 0.5, 0.0, 0.0) == 0
    assert anymal_layout.ground_height(tower, 1.0, 0.0, 0.0) == 5


def test_ground_height_of_unknown_ground_is_nan(anymal_layout):
    assert np.isnan(anymal_layout.ground_height(ElevationMap(np.full((50, 50), np.nan), 0.02), 0, 0, 0))


def test_a_base_off_the_map_is_refused(anymal_layout):
    anymal_layout.check_on_map(plane(0, 0), BasePose(1.49, -1.49, 0.5))
    for x, y in ((1.51, 0), (0, -1.51), (99, 99)):
        with pytest.raises(InputError, match=r"is off the map; the map spans x -1.5..1.5 and y -1.5..1.5 m"):
            anymal_layout.check_on_map(plane(0, 0), BasePose(x, y, 0.5))


def test_a_layout_survives_json(anymal_layout):
    values = json.loads(json.dumps(anymal_layout.to_dict()))
    assert LegLayout.from_dict(values).to_dict() == anymal_layout.to_dict()
