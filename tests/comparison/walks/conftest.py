"""Results of walks written down by hand, to be summed up; what walks really come to is tested with real walks."""

import pytest

from footsel.walking.result import WalkResult
from footsel.walking.runs.trace import Trace


def make_result(terrain="stairs", selector="cnn", seed=0, success=True, reason="", **values):
    """A plausible result."""
    numbers = {
        "distance_m": 4.5 if success else 1.5,
        "duration_s": 80.0 + seed if success else 30.0,
        "steps": 70 if success else 20,
        "slip_mean_mm": 2.0,
        "slip_max_mm": 20.0,
        "shank_impacts": 0,
        "tracking_error_mm": 30.0,
        "min_stability_margin_m": 0.02,
        "hind_shank_contact_s": 0.0,
        "realtime_factor": 4.0,
    } | values
    return WalkResult(terrain, selector, seed, "exact", success, reason, **numbers)


@pytest.fixture
def result():
    """result(terrain, selector, seed, success, reason, slip_max_mm=...) -> WalkResult."""
    return make_result


@pytest.fixture
def results():
    """Ten seeds on stairs and stones. On stairs all arrive, but nominal and terrain_only scrape their hind shanks;
    on stones nominal falls but once."""
    walks = []
    for selector in ("oracle", "cnn", "nominal"):
        for seed in range(10):
            scraped = 0.2 + 0.1 * seed if selector == "nominal" else 0.0
            walks.append(make_result("stairs", selector, seed, hind_shank_contact_s=scraped))
    for selector in ("oracle", "cnn", "nominal"):
        for seed in range(10):
            fell = selector == "nominal" and seed > 0
            walks.append(make_result("stones", selector, seed, not fell, "the base touched the ground" if fell else ""))
    return walks


@pytest.fixture
def traced(results):
    """The same, each with a short trace."""
    trace = Trace(
        base=[(0.1 * k, 0.0, 0.48) for k in range(40)],
        footholds=[("LF", (1.0, 0.25, 0.0)), ("RH", (0.5, -0.25, 0.0))],
        none=[("LF", (1.2, 0.25, 0.48))],
    )
    return [(each, trace) for each in results]
