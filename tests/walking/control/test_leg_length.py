"""A leg is as long as its knee is bent, whatever its abduction."""

import numpy as np
import pytest

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
