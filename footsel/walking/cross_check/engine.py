"""What a collision engine is asked, and how far from the border its answer lies."""

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from footsel.terrain import LocalMap

Vector = NDArray[np.float64]

#: Shifts that are tried, one after another, in all 26 directions of a cube's corners, edges and faces. [m]
SHIFTS = (0.0001, 0.0002, 0.0005, 0.001, 0.002, 0.003, 0.004, 0.005, 0.0075, 0.01, 0.015, 0.02, 0.03)
NO_SHIFT = np.zeros(3)


class Engine(ABC):
    """The collisions of one leg by one engine. Positions are in the heading frame, the hip point at its origin."""

    @abstractmethod
    def stand(self, local_map: LocalMap, tilt: Vector) -> None:
        """Put the base over a terrain, tilted by a rotation (3, 3) from base to heading frame."""

    @abstractmethod
    def self_contacts(self, angles: Vector, shift: Vector = NO_SHIFT) -> list[tuple[str, str]]:
        """Pairs of bodies of the leg and the rest of the robot that touch, the leg alone moved by `shift` (3,) [m]."""

    @abstractmethod
    def terrain_contacts(self, angles: Vector, shift: Vector = NO_SHIFT) -> list[str]:
        """Bodies of the trimmed leg that touch the terrain, the leg moved by `shift` (3,), in [m]."""

    def touches(self, kind: str, angles: Vector, shift: Vector = NO_SHIFT) -> bool:
        """Whether there are contacts of a kind, "self" or "terrain"."""
        return bool(self.self_contacts(angles, shift) if kind == "self" else self.terrain_contacts(angles, shift))

    def distance_to_other_answer(self, kind: str, angles: Vector) -> float:
        """The least shift of SHIFTS after which this engine says the opposite, inf beyond them: how near to touching
        the leg is, from either side, in [m].
        """
        answer = self.touches(kind, angles)
        for length in SHIFTS:
            if any(self.touches(kind, angles, length * direction) != answer for direction in DIRECTIONS):
                return length
        return float("inf")


def _directions() -> list[Vector]:
    steps = [np.array(step, dtype=np.float64) for step in np.ndindex(3, 3, 3)]
    return [(step - 1) / np.linalg.norm(step - 1) for step in steps if (step != 1).any()]


DIRECTIONS = _directions()
