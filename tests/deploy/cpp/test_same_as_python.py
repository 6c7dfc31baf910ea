"""C++ chooses what Python chooses, on courses of every family: tilts, holes, borders, cell sizes, own nominals."""

from collections import Counter

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector
from footsel.terrain.courses import FAMILIES, make_course

CASES = 1000
SIZE = 2.4
RESOLUTIONS = (0.01, 0.015, 0.02, 0.03, 0.04)
VERIFY = {
    0: None,
    1: lambda leg, pose, cell, position: False,
    2: lambda leg, pose, cell, position: (cell[0] + 2 * cell[1]) % 5 == 0,
}


def with_holes(course: ElevationMap, rng: np.random.Generator, position: np.ndarray) -> ElevationMap:
    """Some single cells unknown, a rectangle too, or everything."""
    elevation = course.elevation.copy()
    kind = rng.integers(8)
    if kind < 3:
        elevation[rng.random(elevation.shape) < (0.02, 0.2, 0.9)[kind]] = np.nan
    if kind in (2, 3, 4):
        i, j = rng.integers(elevation.shape)
        elevation[i : i + elevation.shape[0] // 2, j : j + elevation.shape[1] // 2] = np.nan
    if kind == 5 and rng.random() < 0.3:
        elevation[:] = np.nan
    return ElevationMap(elevation, course.resolution, position)


def draw_case(case, course, layout, rng):
    position = rng.uniform(-3, 3, 2) * (rng.random() < 0.5)
    elevation_map = with_holes(course, rng, position)
    # Some bases stand so near to the border that legs reach beyond it.
    x, y = position + rng.uniform(-0.499, 0.499, 2) * elevation_map.size
    yaw = rng.choice([0.0, np.pi / 4, rng.uniform(-np.pi, np.pi)], p=[0.1, 0.1, 0.8])
    roll, pitch = rng.uniform(-0.25, 0.25, 2) * (rng.random() < 0.7)
    ground = layout.ground_height(course, *np.clip((x, y) - position, -1, 1), yaw)
    z = ground + rng.uniform(0.75, 1.2) * layout.standing_height
    legs = tuple(leg for leg in LEGS if rng.random() < 0.6) or ("RH",)
    nominal = {}
    for leg in LEGS:
        if rng.random() < 0.15:
            near = layout.nominal_xy(leg, BasePose(x, y, z, yaw=yaw)) + rng.normal(0, 0.1, 2)
            nominal[leg] = (*near.tolist(), *([float(rng.normal(0, 0.1))] if rng.random() < 0.5 else []))
    previous = {}
    for leg in LEGS:
        if rng.random() < 0.2:
            near = layout.nominal_xy(leg, BasePose(x, y, z, yaw=yaw)) + rng.normal(0, 0.1, 2)
            previous[leg] = tuple(near.tolist())
    return case(
        elevation_map,
        (float(x), float(y), float(z), float(roll), float(pitch), float(yaw)),
        legs,
        nominal,
        previous,
        hysteresis=float(rng.choice([0.0, 10.0, 40.0, np.inf])),
        max_distance=float(rng.choice([np.inf, 0.2, 0.05, 0.001], p=[0.7, 0.1, 0.1, 0.1])),
        top_k=int(rng.choice([1, 1, 3, 16])),
        verify=int(rng.choice(list(VERIFY), p=[0.8, 0.05, 0.15])),
        order=str(rng.choice(["row_major", "column_major", "grid_map"])),
    )


@pytest.fixture(scope="module")
def cases(case, released):
    layout = FootholdSelector.load(released).layout
    rng = np.random.default_rng(5)
    courses = [make_course(family, rng, SIZE, resolution) for family in FAMILIES for resolution in RESOLUTIONS]
    return [draw_case(case, courses[n % len(courses)], layout, rng) for n in range(CASES)]


def by_python(selector, case):
    footholds = selector.select(
        case.elevation_map,
        case.pose,
        case.legs,
        case.nominal,
        top_k=case.top_k,
        verify=VERIFY[case.verify],
        previous=case.previous,
        hysteresis=case.hysteresis,
        max_distance=case.max_distance,
    )
    return {leg: foothold.to_dict() for leg, foothold in footholds.items()}


def assert_same(found, expected):
    """Both are JSON values of `footsel select`."""
    assert found.keys() == expected.keys()
    for key in ("status", "reason", "cell", "class"):
        assert found[key] == expected[key]
    assert found["nominal"] == pytest.approx(expected["nominal"], abs=1e-6)
    if expected["status"] == "none":
        assert all(
            found[key] is None for key in ("position", "cost", "final_cost", "distance_to_nominal", "confidence")
        )
        assert found["alternatives"] == []
        return
    assert found["position"] == pytest.approx(expected["position"], abs=1e-5)
    assert found["distance_to_nominal"] == pytest.approx(expected["distance_to_nominal"], abs=1e-6)
    assert found["confidence"] == pytest.approx(expected["confidence"], abs=1e-5)
    for key in ("cost", "final_cost"):
        assert found[key] == pytest.approx(expected[key], abs=1e-3)
    assert len(found["alternatives"]) == len(expected["alternatives"])
    for one, other in zip(found["alternatives"], expected["alternatives"], strict=True):
        assert one["position"] == pytest.approx(other["position"], abs=1e-5)
        assert one["final_cost"] == pytest.approx(other["final_cost"], abs=1e-3)


def assert_all_same(answers, selector, cases):
    """Footholds as Python chooses them, and what it says in all: leg by leg, (case, expected)."""
    said = []
    for number, (case, answer) in enumerate(zip(cases, answers, strict=True)):
        expected = by_python(selector, case)
        assert answer["footholds"].keys() == expected.keys(), number
        for leg, foothold in expected.items():
            try:
                assert_same(answer["footholds"][leg], foothold)
            except AssertionError as error:
                raise AssertionError(f"case {number}, {leg}: {error}") from None
            said.append((case.previous.get(leg), foothold))
    return said


def test_the_same_footholds_on_a_thousand_cases(cpp, released, cases):
    selector = FootholdSelector.load(released)
    answers = cpp.select(released, cases)
    assert len(answers) == CASES
    outcomes = Counter()
    kept = 0
    for previous, foothold in assert_all_same(answers, selector, cases):
        kept += foothold["position"] is not None and previous == tuple(foothold["position"][:2])
        outcomes[" ".join(word for word in (foothold["reason"] or "ok").split() if not word.isdigit())] += 1
    # The cases are worth something only if they meet every answer.
    assert outcomes["ok"] > CASES
    assert outcomes["no cell of the local map is known"] >= 10
    assert outcomes["the network calls no known cell feasible"] >= 10
    assert outcomes["none of candidates passed the verification"] >= 10
    assert outcomes["no feasible cell lies within 0.001 m of the nominal foothold"] >= 10
    assert kept >= 50


def test_a_difference_would_be_seen(cpp, released, cases):
    """The comparison above can fail: footholds for the base a centimetre further on are others."""
    moved = [
        type(case)(case.elevation_map, (case.pose[0] + 0.01, *case.pose[1:]), case.legs)
        for case in cases[:20]
        if case.elevation_map.contains((case.pose[0] + 0.01, case.pose[1]))
    ]
    selector = FootholdSelector.load(released)
    different = 0
    for answer, case in zip(cpp.select(released, moved), cases[:20], strict=False):
        for leg, foothold in by_python(selector, case).items():
            try:
                assert_same(answer["footholds"][leg], foothold)
            except AssertionError:
                different += 1
    assert different > 10


@pytest.mark.parametrize("leg", LEGS)
@pytest.mark.parametrize("maps", [1, 8, 23])
def test_the_same_cells(cpp, released, leg, maps):
    """evaluate, on maps of one's own: batches of every size, a tilt for each map."""
    rng = np.random.default_rng(maps)
    heights = rng.normal(-0.5, 0.05, (maps, 40, 40)).astype(np.float32)
    heights += np.linspace(-0.3, 0.3, 40, dtype=np.float32)
    heights[rng.random(heights.shape) < 0.1] = np.nan
    tilts = rng.uniform(-0.2, 0.2, (maps, 2))
    expected = FootholdSelector.load(released).evaluate(heights, leg, *tilts.T)
    done = cpp.run("evaluate_maps", released, leg, maps, data=tilts.tobytes() + heights.tobytes())
    assert done.returncode == 0, done.stdout
    cells = heights.size
    cost, confidence = np.frombuffer(done.stdout, np.float32, 2 * cells).reshape(2, *heights.shape)
    feasible = np.frombuffer(done.stdout, np.bool_, cells, 8 * cells).reshape(heights.shape)
    classes = np.frombuffer(done.stdout, np.uint8, cells, 9 * cells).reshape(heights.shape)
    np.testing.assert_array_equal(feasible, expected.feasible)
    np.testing.assert_array_equal(classes, expected.class_)
    np.testing.assert_allclose(cost, expected.cost, atol=1e-3)
    np.testing.assert_allclose(confidence, expected.confidence, atol=1e-5)
    assert 0.01 < feasible.mean() < 0.9
