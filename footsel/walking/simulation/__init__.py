"""ANYmal in PyBullet: torques in, states and contacts out."""

from footsel.walking.simulation.contacts import Contacts
from footsel.walking.simulation.simulation import TIME_STEP, Simulation

__all__ = ["TIME_STEP", "Contacts", "Simulation"]
