"""What is measured during a walk, from the truth."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.walking.control.base_pose import inward_edges
from footsel.walking.gait.stance import counter_clockwise
from footsel.walking.gait.walker import Walker
from footsel.walking.simulation import TIME_STEP, Simulation
from footsel.walking.state import RobotState
from footsel.walking.vectors import length

Array = NDArray[np.float64]

#: Slip and stability are sampled at every so many ticks.
EVERY = 4
#: A shank that hits the ground harder than this could break. [N]
IMPACT = 500.0
#: A foot that the ground pushes less than this does not stand, and its travel is no slip. [N]
STANDING = 20.0


class Metrics:
    """Gathers the figures of WalkResult."""

    def __init__(self, foot_radius: float) -> None:
        self._radius = foot_radius
        self._ticks = 0
        self._slip, self._slip_max = np.zeros((4, 3)), np.zeros(4)
        self._stances: list[float] = []
        self._standing = [True] * 4
        self._impact = [False] * 4
        self.shank_impacts = 0
        self.hind_shank_ticks = 0
        self.tracking_error = 0.0
        self.least_margin = np.inf
        self.touched: dict[str, float] = {}

    def notice(self, simulation: Simulation, state: RobotState, walker: Walker) -> None:
        """After a tick. state: as the walker believed it to be when it gave the torques."""
        contacts = simulation.contacts
        for part in contacts.others:
            self.touched.setdefault(part, simulation.time)
        for k, force in enumerate(contacts.shank_forces):
            self.shank_impacts += force > IMPACT and not self._impact[k]
            self._impact[k] = force > IMPACT
        self.hind_shank_ticks += any(contacts.shank_forces[2:])
        self.tracking_error = max(self.tracking_error, walker.tracking_error(state))
        if self._ticks % EVERY == 0:
            self._watch_feet(simulation, walker)
            corners = counter_clockwise(walker.motion.feet[walker.standing][:, :2])
            normals, offsets = inward_edges(corners)
            self.least_margin = min(self.least_margin, float((normals @ walker.motion.com[:2] - offsets).min()))
        self._ticks += 1

    def figures(self) -> dict[str, Any]:
        """Values by the names of WalkResult."""
        stances = self._stances + [self._slip_max[k] for k in range(4) if self._standing[k]]
        return {
            "slip_mean_mm": 1e3 * float(np.mean(stances)),
            "slip_max_mm": 1e3 * float(np.max(stances)),
            "shank_impacts": self.shank_impacts,
            "tracking_error_mm": 1e3 * self.tracking_error,
            "min_stability_margin_m": self.least_margin,
            "hind_shank_contact_s": self.hind_shank_ticks * TIME_STEP,
        }

    def _watch_feet(self, simulation: Simulation, walker: Walker) -> None:
        """Slip is the way of the foot's material at the contact: a foot that rolls does not slip."""
        velocities = simulation.foot_contact_velocities()
        for k in range(4):
            standing = k in walker.standing
            if standing and not self._standing[k]:
                self._slip[k], self._slip_max[k] = 0.0, 0.0
            elif self._standing[k] and not standing:
                self._stances.append(float(self._slip_max[k]))
            self._standing[k] = standing
            if standing and length(simulation.contacts.foot_forces[k]) > STANDING:
                self._slip[k] += velocities[k] * TIME_STEP * EVERY
                self._slip_max[k] = max(self._slip_max[k], length(self._slip[k]))
