"""Slip trials: how far a loaded ball foot slips when it is pushed, and the terrain cost that is fitted to it."""
