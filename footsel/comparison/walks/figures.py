"""The content of `walks.json`: every run, and per terrain and selector what they come to."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from footsel.comparison.walks.statistics import bootstrap_interval, sign_test, wilson_interval
from footsel.walking.result import WalkResult

#: The selector that the others are compared with, seed by seed, and the one that is compared with all others.
REFERENCE, NETWORK = "oracle", "cnn"

#: Figures of a walk that are averaged; the contract's names.
METRICS = (
    "distance_m",
    "duration_s",
    "steps",
    "slip_mean_mm",
    "slip_max_mm",
    "shank_impacts",
    "hind_shank_contact_s",
    "tracking_error_mm",
    "min_stability_margin_m",
    "realtime_factor",
)
#: Those of them that tell how well the ground was crossed.
COMPARED = (
    "duration_s",
    "slip_max_mm",
    "shank_impacts",
    "hind_shank_contact_s",
    "tracking_error_mm",
    "min_stability_margin_m",
)

#: Terrain -> selector -> its runs in the order of their seeds.
Grouped = Mapping[str, Mapping[str, Sequence[WalkResult]]]


def figures(results: Sequence[WalkResult]) -> dict[str, Any]:
    """`runs` in the given order, `summary` by terrain and selector, and the network minus each other, by terrain."""
    groups = grouped(results)
    return {
        "runs": [result.to_dict() for result in results],
        "summary": {
            terrain: {name: _summary(runs, selectors.get(REFERENCE)) for name, runs in selectors.items()}
            for terrain, selectors in groups.items()
        },
        "network_minus": {
            terrain: {
                name: paired_differences(selectors[NETWORK], runs)
                for name, runs in selectors.items()
                if name != NETWORK
            }
            for terrain, selectors in groups.items()
            if NETWORK in selectors
        },
    }


def grouped(results: Sequence[WalkResult]) -> dict[str, dict[str, list[WalkResult]]]:
    """Results by terrain and selector."""
    groups: dict[str, dict[str, list[WalkResult]]] = {}
    for result in results:
        groups.setdefault(result.terrain, {}).setdefault(result.selector, []).append(result)
    return groups


def kind_of(reason: str) -> str:
    """A reason without its details: those in parentheses, after a colon or semicolon, and how much time there was."""
    return re.split(r" \(|: |; | within ", reason, maxsplit=1)[0]


def _summary(runs: Sequence[WalkResult], reference: Sequence[WalkResult] | None) -> dict[str, Any]:
    """Rates and means; `means_of_successes` leaves failed walks out, which stop early and so spare themselves much."""
    successes = [run for run in runs if run.success]
    summary = {
        "n": len(runs),
        "success_rate": len(successes) / len(runs),
        "ci95": list(wilson_interval(len(successes), len(runs))),
        "failures": dict(Counter(kind_of(run.reason) for run in runs if not run.success).most_common()),
        "means": _means(runs),
        "means_of_successes": _means(successes),
    }
    if reference is not None and reference[0].selector != runs[0].selector:
        summary[f"minus_{REFERENCE}"] = paired_differences(runs, reference)
    return summary


def _means(runs: Sequence[WalkResult]) -> dict[str, float] | None:
    if not runs:
        return None
    return {metric: float(np.mean([getattr(run, metric) for run in runs])) for metric in METRICS}


def paired_differences(runs: Sequence[WalkResult], reference: Sequence[WalkResult]) -> dict[str, Any]:
    """Differences on the same seeds: of success on all, of the figures on those that both walked to the goal."""
    others = {run.seed: run for run in reference}
    pairs = [(run, others[run.seed]) for run in runs if run.seed in others]
    both = [(run, other) for run, other in pairs if run.success and other.success]
    return {
        "success": _difference([float(run.success) - float(other.success) for run, other in pairs]),
        **{
            metric: _difference([float(getattr(run, metric)) - float(getattr(other, metric)) for run, other in both])
            for metric in COMPARED
        },
    }


def _difference(differences: Sequence[float]) -> dict[str, Any] | None:
    """Mean with its interval, and the sign test; None without a pair."""
    if not differences:
        return None
    return {
        "pairs": len(differences),
        "mean": float(np.mean(differences)),
        "ci95": list(bootstrap_interval(differences)),
        "sign_test_p": sign_test(differences),
    }
