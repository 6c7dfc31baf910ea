"""The terrain cost of a cell by its definition, point by point: what the fast one must equal."""

import json
from collections.abc import Callable, Mapping
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.terrain import LocalMap

Vector = NDArray[np.float64]
#: Height above a cell (i, j), in [m]; NaN where unknown or beyond the map.
Surface = Callable[[int, int], float]


def terrain_cost(local_map: LocalMap, cell: tuple[int, int]) -> float:
    """c_m of a known cell: one minus a mixture of Gaussians over K1 and K2 of its neighbourhood (Belter 2011).

    K1 and K2 are slopes: the signed and absolute drops to the points of a stencil on the foot's surface, over what a
    plane of slope 1 would give. For points that are unknown or beyond the local map the worse of two readings holds:
    they are missing, and the quality is known for the others' share alone; or they are as deep as a drop can be.
    """
    features, (i, j) = terrain_cost_data()["features"], cell
    spacing, limit, rings = features["spacing_m"], features["largest_drop_m"], features["ring_weights"]
    heights, step = local_map.heights.astype(np.float64), spacing / local_map.resolution

    def ground(a: int, b: int) -> float:
        return heights[a, b] if 0 <= a < len(heights) and 0 <= b < len(heights) else np.nan

    @cache
    def foot(a: int, b: int) -> float:
        return foot_height(ground, (a, b), step, features)

    drops, weights, plane = [], [], 0.0
    for a in range(-len(rings), len(rings) + 1):
        for b in range(-len(rings), len(rings) + 1):
            if a == b == 0:
                continue
            weight = rings[max(abs(a), abs(b)) - 1]
            plane += weight * abs(a) * spacing
            weights.append(weight)
            drops.append(foot(i, j) - height_between(foot, i + a * step, j + b * step))
    weight, drop = np.array(weights), np.clip(drops, -limit, limit)
    known = ~np.isnan(drop)
    share = weight[known].sum() / weight.sum()
    missing = share * terrain_quality(weight[known], drop[known], plane * share) if known.any() else 0.0
    deep = terrain_quality(weight, np.where(known, drop, limit), plane)
    return float(1 - min(missing, deep))


def terrain_quality(weight: Vector, drop: Vector, plane: float) -> float:
    """The mixture at the features of weighted drops, in [m]; `plane`: the weighted drops of a plane of slope 1."""
    k1, k2 = weight @ drop / plane, weight @ np.abs(drop) / plane
    quality = 0.0
    for g in terrain_cost_data()["gaussians"]:
        offset = np.array([k1 - g["k1"], k2 - g["k2"]])
        covariance = g["correlation"] * g["sigma_k1"] * g["sigma_k2"]
        covariances = np.array([[g["sigma_k1"] ** 2, covariance], [covariance, g["sigma_k2"] ** 2]])
        quality += g["weight"] * np.exp(-offset @ np.linalg.inv(covariances) @ offset / 2)
    return min(quality, 1.0)


def foot_height(ground: Surface, cell: tuple[int, int], step: float, features: Mapping[str, Any]) -> float:
    """Height of the lowest point of the foot, a ball, that touches the ground from above a cell; NaN if unknown.

    It touches under its centre or one stencil point, `step` cells, away, where it reaches down less.
    """
    radius, spacing, (i, j) = features["foot_radius_m"], features["spacing_m"], cell
    touches = []
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            aside = spacing * np.hypot(a, b)
            touches.append(height_between(ground, i + a * step, j + b * step) + np.sqrt(radius**2 - aside**2) - radius)
    return float(np.nanmax(touches)) if not np.isnan(ground(i, j)) else np.nan


@cache
def terrain_cost_data() -> dict[str, Any]:
    """What `footsel terrain-cost fit` found."""
    values: dict[str, Any] = json.loads((resources.files("footsel.oracle") / "terrain_cost.json").read_text("utf-8"))
    return values


def height_between(surface: Surface, i: float, j: float) -> float:
    """Bilinear height at fractional cell indices; NaN if a cell that takes part is unknown."""
    i, j = round(i, 9), round(j, 9)
    low_i, low_j = int(np.floor(i)), int(np.floor(j))
    height = 0.0
    for a, share_a in ((low_i, 1 - (i - low_i)), (low_i + 1, i - low_i)):
        for b, share_b in ((low_j, 1 - (j - low_j)), (low_j + 1, j - low_j)):
            if share_a * share_b > 0:
                height += share_a * share_b * surface(a, b)
    return float(height)
