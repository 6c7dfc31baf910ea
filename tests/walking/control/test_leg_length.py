"""A leg is as long as its knee is bent, whatever its abduction."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.walking.control.leg_length import LegLength

ROBOT = load_robot("anymal_b")


@pytest.mark.parametrize("leg", LEGS)
def test_length_depends_on_the_knee_alone(leg):
    lengths, kinematics = LegLength(ROBOT), ROBOT.kinematics[leg]
    rng = np.random.default_rng(0)
    knee = 0.7 if leg[1] == "H" else -0.7
    angles = np.column_stack([rng.uniform(-0.8, 0.8, 20), rng.uniform(-1, 1, 20), np.full(20, knee)])
    found = lengths.between(lengths.hips[LEGS.index(leg)], kinematics.forward(angles) + kinematics.hip)
    chain = kinematics.thigh + kinematics.shank @ np.array(
        [[np.cos(knee), -np.sin(knee)], [np.sin(knee), np.cos(knee)]]
    )
    np.testing.assert_allclose(found, np.hypot(*chain), atol=1e-9)


@pytest.mark.parametrize("leg", LEGS)
def test_depth_depends_on_thigh_and_knee_alone(leg):
    """However the leg is abducted and the base placed; it is what turns about the axis of abduction."""
    lengths, kinematics = LegLength(ROBOT), ROBOT.kinematics[leg]
    rng = np.random.default_rng(0)
    thigh, knee = rng.uniform(-3, 3, (2, 20))
    for q1, q2, q3 in zip(rng.uniform(-3, 3, 20), thigh, knee, strict=True):
        rotation, position = Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3)
        foot = kinematics.forward(np.array([q1, q2, q3])) + kinematics.hip
        straight = kinematics.forward(np.array([0.0, q2, q3])) + kinematics.hip - kinematics.haa
        hip = lengths.hips[LEGS.index(leg)]
        found = lengths.depth(rotation, position + rotation @ hip, position + rotation @ foot)
        assert found == pytest.approx(abs(straight[2]), abs=1e-6)
        assert found <= lengths.between(hip, foot) + 1e-9
