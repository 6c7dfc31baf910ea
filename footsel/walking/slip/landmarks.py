"""Shapes with a name, tried one by one: what slips there beside what the fitted cost says."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.oracle.terrain_cost import TerrainCostModel, terrain_features
from footsel.terrain import ElevationMap
from footsel.walking.slip.campaign import COURSE_RESOLUTION, FRICTIONS
from footsel.walking.slip.fit import slip_cost
from footsel.walking.slip.trial import slip_trials, slip_world

#: Feet set down on each shape, each with touchdown errors of its own.
FEET = 60
#: Cells from the middle, where the feet are sent, to the rim.
HALF = 15

Heights = NDArray[np.float64]


def landmarks() -> Iterator[tuple[str, Heights]]:
    """Name and heights (2 HALF + 1, 2 HALF + 1) of each shape, the foot's cell in the middle, in [m]."""
    along = np.arange(-HALF, HALF + 1) * COURSE_RESOLUTION
    x, y = np.meshgrid(along, along, indexing="ij")
    cell = COURSE_RESOLUTION / 2
    yield "level", 0 * x
    for degrees in (10, 15, 20):
        yield f"plane of {degrees} degrees", np.tan(np.deg2rad(degrees)) * x
    for height in (0.01, 0.03, 0.1):
        yield f"upper edge of a step of {100 * height:g} cm", np.where(x > cell, -height, 0.0)
    for height in (0.01, 0.02, 0.05):
        yield f"foot of a step of {100 * height:g} cm", np.where(x > cell, height, 0.0)
    for height in (0.01, 0.05):
        yield f"pit, one cell, {100 * height:g} cm", np.where(np.hypot(x, y) < cell, -height, 0.0)
        yield f"pit, 3x3 cells, {100 * height:g} cm", np.where(np.maximum(abs(x), abs(y)) < 3 * cell, -height, 0.0)
        yield f"spike, one cell, {100 * height:g} cm", np.where(np.hypot(x, y) < cell, height, 0.0)
        yield f"ridge, one cell, {100 * height:g} cm", np.where(abs(x) < cell, height, 0.0)
        yield f"groove, one cell, {100 * height:g} cm", np.where(abs(x) < cell, -height, 0.0)


def measure(model: TerrainCostModel, foot_radius: float) -> dict[str, dict[str, Any]]:
    """{shape: {"cost": the model's, "measured": the target of the fit}}.

    foot_radius: in [m].
    """
    found = {}
    for name, heights in landmarks():
        course = ElevationMap(heights.astype(np.float32), COURSE_RESOLUTION)
        with slip_world(course, foot_radius, FEET) as world:
            rng, middle = np.random.default_rng(0), np.zeros((FEET, 2))
            slips = np.stack([slip_trials(world, middle, friction, rng) for friction in FRICTIONS], axis=1)
        k1, k2, _ = terrain_features(heights, COURSE_RESOLUTION)
        cost = float(model.cost(k1[HALF, HALF], k2[HALF, HALF]))
        found[name] = {"cost": round(cost, 3), "measured": round(float(slip_cost(slips).mean()), 3)}
    return found
