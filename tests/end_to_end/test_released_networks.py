"""What the networks in export/ promise, held against the oracle on fresh ground."""

import pytest

from footsel.comparison.compare import compare
from footsel.comparison.maps import built_in_courses
from footsel.runtime import FootholdSelector

#: Of no course that a network was trained, or its threshold chosen, on.
SEED = 300


@pytest.fixture(scope="module")
def figures():
    # Of 1,000 picks of which 0.5 % are wrong, chance alone makes 0.7 % one time in six.
    return compare(built_in_courses(SEED), ["oracle", "cnn", "cnn+verify"], poses=100, seed=SEED).figures()


def test_the_network_errs_as_rarely_as_it_says(figures):
    cnn, cells = figures["selectors"]["cnn"], figures["cells"]["cnn"]
    assert cnn["picks"] > 4000
    assert cnn["infeasible_rate"] <= 0.007 and cnn["missed_rate"] <= 0.01 and cnn["regret_mean"] <= 4
    assert cnn["unknown_picks"] == 0
    assert cells["accuracy"] >= 0.95 and cells["miou_present"] >= 0.85 and cells["false_safe_rate"] <= 0.01


def test_verified_it_never_errs(figures):
    assert figures["selectors"]["cnn+verify"]["infeasible_picks"] == 0


def test_the_paper_s_networks_answer_too():
    course = built_in_courses(SEED)[0].elevation_map
    selector = FootholdSelector.load("anymal_b_paper")
    ground = selector.layout.ground_height(course, 0.0, 0.0, 0.0)
    footholds = selector.select(course, (0.0, 0.0, ground + selector.layout.standing_height, 0.0, 0.0, 0.0))
    assert {foothold.status for foothold in footholds.values()} == {"ok"}
