"""Depths on a grid so coarse that sums of a few are exact in float32: engines that add in another order agree."""

from torch import Tensor

#: Steps per image depth: 3.2 micrometres for ANYmal. Of a float32's 24 bits that leaves six: sums stay below 64.
STEPS = 2.0**18


def on_grid(depth: Tensor) -> Tensor:
    """The nearest depths on the grid, in the unit of the image."""
    return (depth * STEPS).round() / STEPS
