"""Smooth motion of a vector from one state to another: quintic polynomials."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Quintic:
    """A motion over `duration` from `start` [s] on; beyond its end it goes on at the end's velocity.

    coefficients: (6, n) of rising powers of the time since `start`.
    """

    start: float
    duration: float
    coefficients: Array

    @classmethod
    def between(
        cls,
        start: float,
        duration: float,
        first: tuple[ArrayLike, ArrayLike, ArrayLike],
        last: ArrayLike,
        speed: ArrayLike,
    ) -> "Quintic":
        """From position, velocity and acceleration (n,) to a position at a velocity, without acceleration."""
        p, v, a = (np.asarray(part, dtype=np.float64) for part in first)
        end, end_v = np.asarray(last, dtype=np.float64), np.asarray(speed, dtype=np.float64)
        T = duration
        # What is left for the three highest powers to make good at the end.
        d0 = end - (p + v * T + a * T**2 / 2)
        d1 = end_v - (v + a * T)
        d2 = -a
        c3 = (10 * d0 - 4 * d1 * T + d2 * T**2 / 2) / T**3
        c4 = (-15 * d0 + 7 * d1 * T - d2 * T**2) / T**4
        c5 = (6 * d0 - 3 * d1 * T + d2 * T**2 / 2) / T**5
        return cls(start, duration, np.stack([p, v, a / 2, c3, c4, c5]))

    @property
    def end(self) -> float:
        """When it ends, in [s]."""
        return self.start + self.duration

    def at(self, time: float) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration (n,)."""
        t = time - self.start
        beyond = max(t - self.duration, 0.0)
        t = min(max(t, 0.0), self.duration)
        c = self.coefficients
        position = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))
        velocity = c[1] + t * (2 * c[2] + t * (3 * c[3] + t * (4 * c[4] + t * 5 * c[5])))
        if beyond > 0:
            return position + beyond * velocity, velocity, np.zeros_like(position)
        return position, velocity, 2 * c[2] + t * (6 * c[3] + t * (12 * c[4] + t * 20 * c[5]))
