"""The terrain cost c_m fitted to slip trials, and how well it obeys physics and predicts trials it has not seen."""

import platform
from dataclasses import asdict
from typing import Any

import numpy as np
import pybullet
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import spearmanr

import footsel
from footsel.oracle.terrain_cost import (
    LARGEST_DROP,
    RING_WEIGHTS,
    SPACING,
    Gaussian,
    TerrainCostModel,
    terrain_features,
)
from footsel.walking.slip import trial
from footsel.walking.slip.campaign import FRICTIONS, CampaignConfig, Trials

Array = NDArray[np.float64]

#: Share of a placement's pushes, the worst ones, that it is judged by: who plans a step does not choose the push.
WORST_SHARE = 0.25

COMPONENTS, STARTS = 5, 6
#: Bounds of weight, k1, k2, ln sigma_k1, ln sigma_k2, atanh(correlation).
_LOW, _HIGH = (0.0, -1.5, -0.5, -3.0, -3.0, -1.8), (4.0, 1.5, 1.0, 1.0, 1.0, 1.8)

#: What the fit must keep to, each with the factor of its violation in the residuals.
_STEEPEST = 1.0
_SLOPES = np.linspace(0.0, 1.1 * _STEEPEST, 100)
_EDGE_HEIGHTS = np.arange(0, 0.0551, 0.0025)
_HIGH_EDGE, _HIGH_EDGE_COST = 0.0299, 0.54
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

    Three laws are part of the least squares: level ground costs nothing; a steeper plane and a higher step, at its
    upper edge and at its foot, never cost less; and the upper edge of a step of 3 cm or more costs at least 0.54.
    """
    k1, k2, target = trials.k1, trials.k2, slip_cost(trials.slip)
    edges = np.concatenate([_edge_features(height) for height in _EDGE_HEIGHTS], axis=1)
    feet = np.concatenate([_edge_features(-height) for height in _EDGE_HEIGHTS], axis=1)
    high = _EDGE_HEIGHTS > _HIGH_EDGE

    def residuals(parameters: Array) -> Array:
        model = _model(parameters)
        cost = 1 - model.quality(k1, k2)
        plane = 1 - model.quality(np.zeros_like(_SLOPES), _SLOPES)
        edge, foot = 1 - model.quality(*edges), 1 - model.quality(*feet)
        laws = [
            50 * plane[:1],
            *(5000 * np.maximum(_LEAST_RISE - np.diff(grows), 0) for grows in (plane, edge, foot)),
            100 * np.maximum(_HIGH_EDGE_COST - edge[high], 0),
        ]
        return np.concatenate([cost - target, *laws])

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
    cost, target = model.cost(trials.k1, trials.k2), slip_cost(trials.slip)
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
        "features": {"spacing_m": SPACING, "ring_weights": list(RING_WEIGHTS), "largest_drop_m": LARGEST_DROP},
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


def _model(parameters: Array) -> TerrainCostModel:
    return TerrainCostModel(
        tuple(
            Gaussian(*map(float, (w, c1, c2, np.exp(s1), np.exp(s2), np.tanh(r))))
            for w, c1, c2, s1, s2, r in parameters.reshape(-1, 6)
        )
    )


def _edge_features(height: float) -> tuple[Array, Array]:
    """Features of the last cell before a step down by `height` (up, if negative), in [m]."""
    return _middle_features(np.where(np.arange(9)[:, None] > 4, -height, np.zeros((9, 9))))


def _plane_features(angle: float) -> tuple[Array, Array]:
    return _middle_features(np.tan(angle) * SPACING * np.arange(9.0)[:, None] + np.zeros((9, 9)))


def _middle_features(heights: Array) -> tuple[Array, Array]:
    k1, k2, _ = terrain_features(heights, SPACING)
    return k1[4:5, 4], k2[4:5, 4]


def _spearman(cost: Array, slip: Array) -> float | None:
    if np.ptp(cost) < 1e-9 or np.ptp(slip) < 1e-9:
        return None
    return round(float(spearmanr(cost, slip)[0]), 4)


def _round(cost: Array) -> float:
    return round(float(cost[0]), 4)
