"""The terrain cost c_m fitted to slip trials, and how well it obeys physics and predicts trials it has not seen."""

import platform
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import spearmanr

import footsel
from footsel.oracle.terrain_cost import (
    FOOT_RADIUS,
    LARGEST_DROP,
    LARGEST_FEATURE,
    RING_WEIGHTS,
    SPACING,
    Gaussian,
    TerrainCostModel,
    terrain_features,
)
from footsel.walking.bullet import pybullet
from footsel.walking.slip import trial
from footsel.walking.slip.campaign import FRICTIONS, CampaignConfig, Trials

Array = NDArray[np.float64]

#: Share of a placement's pushes, the worst ones, that it is judged by: who plans a step does not choose the push.
WORST_SHARE = 0.25

COMPONENTS, STARTS = 5, 6
#: Placements whose features are this near to each other are one residual.
_GROUP = 0.02
#: Bounds of weight, k1, k2, ln sigma_k1, ln sigma_k2, atanh(correlation).
_LOW, _HIGH = (0.0, -1.5, -0.5, -3.0, -3.0, -1.8), (4.0, 1.5, 1.0, 1.0, 1.0, 1.8)

#: What the fit must keep to, each with the factor of its violation in the residuals.
_STEEPEST = 1.0
_SLOPES = np.linspace(0.0, 1.1 * _STEEPEST, 100)
_EDGE_HEIGHTS = np.concatenate([np.arange(0, 0.0551, 0.0025), [0.07, 0.085, 0.1]])
_HIGH_EDGE, _HIGH_EDGE_COST = 0.0299, 0.54
#: A cell that falls off to more and more sides, as unknown cells do when they are read as deep.
_FALLS = np.linspace(0.0, LARGEST_FEATURE, 60)
#: The cost of a shape may change by this if it is seen in cells of twice the size.
_CELL_SIZE_TOLERANCE = 0.075
#: Domes and, negative, bowls: their curvatures, in [1/m].
_CURVATURES = (-6.0, -4.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
#: Between neighbouring values of the two above: so that nothing falls in between.
_LEAST_RISE = 5e-5


def slip_cost(slip: Array) -> Array:
    """(n,) target of the fit, in [0, 1]: mean slip of the worst quarter of pushes, as a share of the largest.

    slip: (n, frictions, directions) in [m].
    """
    pushes = np.sort(slip.reshape(len(slip), -1), axis=1)
    worst = max(round(WORST_SHARE * pushes.shape[1]), 1)
    return np.asarray(pushes[:, -worst:].mean(axis=1) / trial.SLIP_CAP)


def fit_model(trials: Trials) -> TerrainCostModel:
    """The mixture of least squares over the trials' features, from several starts.

    Laws are part of the least squares: level ground costs nothing; a steeper plane, a higher step, at its upper edge
    and at its foot, and a cell that falls off to more sides never cost less; the upper edge of a step of 3 cm or more
    costs at least 0.54; and edges, domes and bowls cost much the same in cells of 2 and of 4 cm.
    """
    k1, k2, target, count = _grouped(*trials.features, slip_cost(trials.slip))
    weight = np.sqrt(count)
    edges = np.concatenate([_edge_features(height) for height in _EDGE_HEIGHTS], axis=1)
    feet = np.concatenate([_edge_features(-height) for height in _EDGE_HEIGHTS], axis=1)
    fine, coarse = _features_of_shapes(SPACING), _features_of_shapes(2 * SPACING)
    high = _EDGE_HEIGHTS > _HIGH_EDGE

    def residuals(parameters: Array) -> Array:
        model = _model(parameters)
        cost = 1 - model.quality(k1, k2)
        plane = 1 - model.quality(np.zeros_like(_SLOPES), _SLOPES)
        fall = 1 - model.quality(_FALLS, _FALLS)
        edge, foot = 1 - model.quality(*edges), 1 - model.quality(*feet)
        other_size = model.quality(*fine) - model.quality(*coarse)
        laws = [
            50 * plane[:1],
            *(5000 * np.maximum(_LEAST_RISE - np.diff(grows), 0) for grows in (plane, edge, foot, fall)),
            100 * np.maximum(_HIGH_EDGE_COST - edge[high], 0),
            100 * np.maximum(np.abs(other_size) - _CELL_SIZE_TOLERANCE, 0),
        ]
        return np.concatenate([weight * (cost - target), *laws])

    best = None
    for start in range(STARTS):
        rng = np.random.default_rng(start)
        first = np.column_stack(
            [
                np.full(COMPONENTS, 0.7),
                rng.uniform(-0.1, 0.5, COMPONENTS),
                rng.uniform(0, 0.4, COMPONENTS),
                np.full((COMPONENTS, 2), -1.9),
                np.zeros(COMPONENTS),
            ]
        )
        bounds = (np.tile(_LOW, COMPONENTS), np.tile(_HIGH, COMPONENTS))
        found = least_squares(residuals, first.ravel(), bounds=bounds, max_nfev=300)
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    return _model(best.x)


def scores(model: TerrainCostModel, trials: Trials) -> dict[str, Any]:
    """How the cost goes with measured slip: Spearman's correlation with two measures of it, the explained variance."""
    cost, target = model.cost(*trials.features), slip_cost(trials.slip)
    figures: dict[str, Any] = {
        "placements": len(trials),
        "spearman_worst_quarter": _spearman(cost, target),
        "spearman_mean_slip": _spearman(cost, trials.slip.mean(axis=(1, 2))),
        "explained_variance": round(float(1 - np.var(cost - target) / max(np.var(target), 1e-12)), 4),
        "mean_slip_mm": round(float(trials.slip.mean() * 1e3), 3),
    }
    return figures


def report(model: TerrainCostModel, trials: Trials) -> dict[str, Any]:
    """All figures: of the fitted courses, of the others, evenly drawn or not, by family; and the laws."""
    fitted, held_out = trials.take(~trials.held_out), trials.take(trials.held_out)
    return {
        "fitted": scores(model, fitted),
        "held_out": scores(model, held_out),
        "held_out_uniform": scores(model, held_out.take(held_out.uniform)),
        "held_out_by_family": {
            family: scores(model, held_out.take(held_out.family == family)) for family in sorted(set(held_out.family))
        },
        "laws": laws(model),
    }


def laws(model: TerrainCostModel) -> dict[str, Any]:
    """Costs of shapes that everyone knows the answer for."""
    angles = range(0, 46, 5)
    return {
        "slope_deg": {str(angle): _round(model.cost(*_plane_features(np.deg2rad(angle)))) for angle in angles},
        "upper_edge_cm": {f"{100 * h:g}": _round(model.cost(*_edge_features(h))) for h in _STEPS},
        "foot_of_step_cm": {f"{100 * h:g}": _round(model.cost(*_edge_features(-h))) for h in _STEPS},
    }


def data_file(model: TerrainCostModel, config: CampaignConfig, figures: dict[str, Any]) -> dict[str, Any]:
    """The values of terrain_cost.json."""
    return {
        "about": "c_m = 1 - sum of Gaussians over (K1, K2), see footsel/oracle/terrain_cost.py",
        "gaussians": [{key: round(value, 6) for key, value in asdict(g).items()} for g in model.gaussians],
        "features": {
            "spacing_m": SPACING,
            "ring_weights": list(RING_WEIGHTS),
            "largest_drop_m": LARGEST_DROP,
            "foot_radius_m": FOOT_RADIUS,
        },
        "provenance": {
            "command": "footsel terrain-cost fit OUT "
            f"--placements {config.placements} --held-out {config.held_out} --seed {config.seed}",
            "target": f"mean slip of the worst {WORST_SHARE:.0%} of pushes, over {trial.SLIP_CAP} m",
            "trial": {
                "frictions": list(FRICTIONS),
                "push_shares_of_mu_n": list(trial.PUSH_SHARES),
                "directions": trial.DIRECTIONS,
                "settle_s": trial.SETTLE_SECONDS,
                "push_s": trial.PUSH_SECONDS,
                "slip_cap_m": trial.SLIP_CAP,
                "touchdown_error_m": trial.TOUCHDOWN_ERROR,
            },
            "versions": {
                "footsel": footsel.__version__,
                "pybullet": str(pybullet.getAPIVersion()),
                "python": platform.python_version(),
                "numpy": np.__version__,
            },
        },
        "figures": figures,
    }


_STEPS = (0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.3)


def _grouped(k1: Array, k2: Array, target: Array) -> tuple[Array, Array, Array, Array]:
    """Means of K1, K2 and target over cells of the feature plane, and how many placements each cell has.

    The least squares are the same but for what varies within a cell, and ten times as fast.
    """
    cells = np.round(np.column_stack([k1, k2]) / _GROUP).astype(np.int64)
    _, group, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    k1, k2, target = (np.bincount(group.ravel(), values) / count for values in (k1, k2, target))
    return k1, k2, target, count.astype(np.float64)


def _model(parameters: Array) -> TerrainCostModel:
    return TerrainCostModel(
        tuple(
            Gaussian(*map(float, (w, c1, c2, np.exp(s1), np.exp(s2), np.tanh(r))))
            for w, c1, c2, s1, s2, r in parameters.reshape(-1, 6)
        )
    )


def _edge_features(height: float, resolution: float = SPACING) -> tuple[Array, Array]:
    """Features of the last cell before a step down by `height` (up, if negative), in [m]; cells of `resolution`."""
    return _middle_features(np.where(_ALONG > 0.5, -height, 0.0), resolution)


def _features_of_shapes(resolution: float) -> tuple[Array, Array]:
    """Features of the upper edges of steps, and of the middle of domes and bowls, in cells of `resolution`."""
    square = (_ALONG**2 + _ALONG.T**2) * resolution**2
    domes = [_middle_features(-curvature / 2 * square, resolution) for curvature in _CURVATURES]
    edges = [_edge_features(height, resolution) for height in _EDGE_HEIGHTS]
    k1, k2 = np.concatenate([*edges, *domes], axis=1)
    return k1, k2


def _plane_features(angle: float) -> tuple[Array, Array]:
    return _middle_features(np.tan(angle) * SPACING * _ALONG)


def _middle_features(heights: Array, resolution: float = SPACING) -> tuple[Array, Array]:
    k1, k2, _ = terrain_features(heights, resolution)
    return k1[4:5, 4], k2[4:5, 4]


#: (9, 9) distance along x from the middle cell, in cells.
_ALONG = np.arange(-4.0, 5.0)[:, None] + np.zeros((9, 9))


def _spearman(cost: Array, slip: Array) -> float | None:
    if np.ptp(cost) < 1e-9 or np.ptp(slip) < 1e-9:
        return None
    return round(float(spearmanr(cost, slip)[0]), 4)


def _round(cost: Array) -> float:
    return round(float(cost[0]), 4)
