"""What the robot knows of itself: its state, and who estimates it."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RobotState:
    """The robot at one time. Joints are ordered by LEGS and HAA HFE KFE, feet by LEGS.

    time: in [s]. base: (4, 4) placement of the base in W.
    linear, angular: (3,) velocity of the base's origin and of the base, both in W, in [m/s] and [rad/s].
    joints, joint_velocities: (12,) in [rad] and [rad/s].
    foot_forces: (4, 3) force of the ground on each foot, in W, in [N]: what its force sensor says.
    """

    time: float
    base: Array
    linear: Array
    angular: Array
    joints: Array
    joint_velocities: Array
    foot_forces: Array


class StateEstimator(ABC):
    """Says what the robot believes of its state; controller and map source know no other."""

    @abstractmethod
    def estimate(self, truth: RobotState) -> RobotState:
        """The estimate at the true state's time; called once for every tick of the controller, in order."""


class GroundTruth(StateEstimator):
    """The robot knows exactly where it is."""

    def estimate(self, truth: RobotState) -> RobotState:
        return truth
