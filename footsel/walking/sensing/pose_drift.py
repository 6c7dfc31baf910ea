"""The pose that a robot believes it has: the true one, and an error that grows as it goes.

What legged state estimation leaves, put as a model instead of being simulated from an IMU and the legs: position and
yaw, which nothing observes, drift as a random walk with the way that the base goes, its swaying included; roll and
pitch, which gravity tells, are off by a little that comes and goes. The sizes are assumed: 1 cm of position and 0.5
degrees of yaw after 1 m, 0.2 degrees of tilt.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from footsel.walking.state import RobotState, StateEstimator

Array = NDArray[np.float64]


@dataclass(frozen=True)
class DriftRates:
    """position: standard deviation along each axis after 1 m, in [m]. yaw: after 1 m, in [rad].

    tilt: of roll and of pitch, in [rad]; tilt_time: how long their error lasts, in [s].
    """

    position: float = 0.01
    yaw: float = float(np.deg2rad(0.5))
    tilt: float = float(np.deg2rad(0.2))
    tilt_time: float = 2.0


class PoseDrift(StateEstimator):
    """The true state with a base that is believed elsewhere; the first place is exact but for the tilt.

    Velocities and forces are known in the base's frame and turned with it; joints are known.
    """

    def __init__(self, rng: np.random.Generator, rates: DriftRates | None = None) -> None:
        self.rates = rates or DriftRates()
        self._rng = rng
        self._last: RobotState | None = None
        self._position, self._yaw, self._tilt = np.zeros(3), 0.0, np.zeros(2)
        self._drifted = np.zeros((4, 4))

    def estimate(self, truth: RobotState) -> RobotState:
        """As above."""
        rates, rng, last = self.rates, self._rng, self._last
        if last is None:
            self._position = truth.base[:3, 3].copy()
            self._tilt = rng.normal(0, rates.tilt, 2)
        else:
            step = _turn_about_z(self._yaw) @ (truth.base[:3, 3] - last.base[:3, 3])
            carried = np.eye(4)
            carried[:2, 3] = -step[1], step[0]
            noise = np.array([rates.position**2] * 3 + [rates.yaw**2]) * np.linalg.norm(step)
            self._drifted = carried @ self._drifted @ carried.T + np.diag(noise)
            *slip, turn = rng.normal(0, np.sqrt(noise))
            self._position = self._position + step + slip
            self._yaw += turn
            kept = np.exp(-(truth.time - last.time) / rates.tilt_time)
            self._tilt = kept * self._tilt + np.sqrt(1 - kept**2) * rng.normal(0, rates.tilt, 2)
        self._last = truth
        error = _small_turn(*self._tilt) @ _turn_about_z(self._yaw)
        base = np.eye(4)
        base[:3, :3] = error @ truth.base[:3, :3]
        base[:3, 3] = self._position
        return replace(
            truth,
            base=base,
            linear=error @ truth.linear,
            angular=error @ truth.angular,
            foot_forces=truth.foot_forces @ error.T,
        )

    def covariance(self) -> Array:
        """(6, 6) of the last estimate: x, y, z, in [m], and a rotation vector, in [rad], along W's axes."""
        covariance = np.diag([0, 0, 0, self.rates.tilt**2, self.rates.tilt**2, 0])
        drifting = np.ix_([0, 1, 2, 5], [0, 1, 2, 5])
        covariance[drifting] = self._drifted
        return covariance


def _turn_about_z(yaw: float) -> Array:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _small_turn(about_x: float, about_y: float) -> Array:
    """(3, 3) rotation by the vector (about_x, about_y, 0), in [rad]."""
    angle = float(np.hypot(about_x, about_y))
    if angle == 0:
        return np.eye(3)
    x, y = about_x / angle, about_y / angle
    cross = np.array([[0, 0, y], [0, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
