"""How the map grows uncertain as the robot moves: it is known relative to the robot, whose pose drifts.

Fankhauser et al. 2014, equations 24 and 25 and the appendix: the error of the pose now, less what of it was there
before, is the error of the motion in between.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MotionVariance:
    """height: what the variance of all heights grows by, in [m^2]. x, y: of all places, in [m^2].

    yaw: variance of the turn, in [rad^2]. about: (2,) world xy that it turns about, in [m].
    """

    height: float
    x: float
    y: float
    yaw: float
    about: Array

    def of_places(self, xy: Array) -> Array:
        """(..., 2) what the variances of the x and y of world points (..., 2) grow by, in [m^2]."""
        lever = xy - self.about
        # A turn moves a point across its lever.
        return np.stack([self.x + self.yaw * lever[..., 1] ** 2, self.y + self.yaw * lever[..., 0] ** 2], axis=-1)


def motion_variance(before: Array, covariance_before: Array, after: Array, covariance_after: Array) -> MotionVariance:
    """Between two poses of the base.

    before, after: (4, 4) placements in W. covariance_*: (6, 6) of x, y, z, in [m], and of a rotation vector, in [rad],
    all along W's axes. What cannot be, a variance that shrinks because the pose became more certain, counts as 0.
    """
    travel = after[:3, 3] - before[:3, 3]
    carried = np.eye(4)
    carried[:2, 3] = -travel[1], travel[0]
    was, now = _reduced(covariance_before), _reduced(covariance_after)
    x, y, z, yaw = np.maximum(np.diag(now - carried @ was @ carried.T), 0).tolist()
    return MotionVariance(z, x, y, yaw, before[:2, 3])


def _reduced(covariance: Array) -> Array:
    """(4, 4) of x, y, z and yaw: gravity keeps roll and pitch from drifting."""
    kept = [0, 1, 2, 5]
    return covariance[np.ix_(kept, kept)]


def attitude_variance(points_xy: Array, base: Array, covariance: Array) -> Array:
    """(k,) variance of the height of world points (k, 2) from the attitude of the base that sees them, in [m^2].

    The term `J_q S_q J_q'`: an error (a, b) of the rotation about W's x and y lifts a point by `a r_y - b r_x`.
    """
    lever = points_xy - base[:2, 3]
    jacobian = np.stack([lever[:, 1], -lever[:, 0]], axis=-1)
    return np.asarray(np.einsum("ki,ij,kj->k", jacobian, covariance[3:5, 3:5], jacobian))
