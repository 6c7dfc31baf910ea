"""The vectorised selection against a plain one: leg by leg, footholds.prepare, evaluate and footholds.choose."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footsel import ElevationMap
from footsel.footholds import BasePose, CellScores, LegLayout, choose
from footsel.footholds.cost import cost_to_class
from footsel.footholds.request import prepare
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector
from footsel.runtime.leg_frames import Body
from footsel.runtime.sampling import sample_legs


@pytest.fixture(scope="module")
def selector(tmp_path_factory, handmade, anymal_layout):
    """Front and hind networks of different thresholds."""
    files = {
        f"{pair}.onnx": handmade.random_model(handmade.contract(anymal_layout, pair, feasible_below=below), seed)
        for seed, (pair, below) in enumerate({"front": 0.2, "hind": 0.35}.items())
    }
    return FootholdSelector.load(handmade.write_folder(tmp_path_factory.mktemp("reference") / "model", files))


def reference(selector, elevation_map, pose, legs=LEGS, nominal=None, top_k=1):
    """As `select` answers, by the code that every other selector uses."""
    found = {}
    for request in prepare(selector.layout, elevation_map, pose, legs, nominal):
        cells = selector.evaluate(request.local_map.heights, request.leg, request.pose.roll, request.pose.pitch)
        scores = CellScores(cells.cost, cells.feasible, "the network calls no known cell feasible", cells.confidence)
        found[request.leg] = choose(scores, request.local_map, request.nominal, top_k)
    return found


#: Networks answer batches of other sizes with other last bits; candidates nearer than this are tied. [cost]
TIE = 2e-3


def candidates(foothold):
    """(k, 3) positions and (k,) final costs, best first."""
    places = [foothold.position, *(a.position for a in foothold.alternatives)]
    return np.array(places), np.array([foothold.final_cost, *(a.final_cost for a in foothold.alternatives)])


def check_same(found, expected):
    """Both with the same `top_k` of 2 or more; the last place is not compared, it may be tied with one not named."""
    for leg, other in expected.items():
        one = found[leg]
        assert (one.status, one.reason) == (other.status, other.reason)
        np.testing.assert_allclose(one.nominal, other.nominal, atol=1e-5)
        if one.status == "none":
            continue
        (places, costs), (other_places, other_costs) = candidates(one), candidates(other)
        np.testing.assert_allclose(costs, other_costs, atol=TIE)
        gaps = np.diff(costs, prepend=-np.inf, append=np.inf)
        decided = np.minimum(gaps[:-1], gaps[1:]) > TIE
        decided[-1] &= len(costs) == 1
        np.testing.assert_allclose(places[decided], other_places[decided], atol=1e-5)
        if decided[0]:
            assert one.cell == other.cell
            for name in ("cost", "distance_to_nominal", "confidence"):
                assert getattr(one, name) == pytest.approx(getattr(other, name), abs=TIE), name


shapes = st.tuples(st.integers(2, 130), st.integers(2, 130))
angles = st.floats(-np.pi, np.pi)


@st.composite
def situations(draw):
    """A rough map of any shape, place and cell size, holes in it, and a base anywhere on it at any tilt."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    resolution = draw(st.sampled_from([0.02, 0.01, 0.0173, 0.05, 0.2]))
    shape = draw(shapes)
    elevation = rng.uniform(-0.15, 0.15, shape) + draw(st.sampled_from([0.0, -3.0, 40.0]))
    level = elevation.mean()
    elevation[rng.random(shape) < draw(st.sampled_from([0.0, 0.02, 0.3, 0.95, 1.0]))] = np.nan
    position = rng.uniform(-5, 5, 2)
    elevation_map = ElevationMap(elevation, resolution, position)
    x, y = position + rng.uniform(-0.499, 0.499, 2) * elevation_map.size
    pose = BasePose(x, y, level + 0.47, *rng.uniform(-0.3, 0.3, 2), draw(angles))
    return elevation_map, pose


@settings(deadline=None, max_examples=150)
@given(situation=situations(), top_k=st.sampled_from([2, 5]), legs=st.sets(st.sampled_from(LEGS)))
def test_select_is_the_plain_selection(selector, situation, top_k, legs):
    elevation_map, pose = situation
    found = selector.select(elevation_map, pose, legs, top_k=top_k)
    check_same(found, reference(selector, elevation_map, pose, legs, top_k=top_k))
    for leg, foothold in selector.select(elevation_map, pose, legs).items():
        assert foothold == replace(found[leg], alternatives=())
        assert foothold.status == "none" or foothold.class_ == cost_to_class(foothold.cost)


@settings(deadline=None, max_examples=150)
@given(situation=situations())
def test_local_maps_are_those_of_the_layout(anymal_layout, situation):
    """To float32's rounding, and every unknown cell."""
    elevation_map, pose = situation
    frames = Body(anymal_layout).place(np.array([pose.as_list()]), LEGS, {})
    heights, terrain = sample_legs(
        elevation_map, frames.hips, frames.heading, frames.side, frames.nominal[:, :2], anymal_layout.resolution
    )
    np.testing.assert_allclose(terrain, elevation_map.sample(frames.nominal[:, :2]), atol=2e-5)
    nominal = frames.nominal_on(terrain)
    for number, leg in enumerate(LEGS):
        expected = anymal_layout.local_map(elevation_map, pose, leg)
        seen = heights[number] if leg[0] == "L" else heights[number][:, ::-1]
        np.testing.assert_allclose(seen, expected.heights, atol=2e-5)
        np.testing.assert_allclose(frames.hips[number], expected.hip, atol=1e-12)
        point = anymal_layout.nominal_xy(leg, pose)
        np.testing.assert_allclose(
            nominal[number], anymal_layout.nominal_position(leg, pose, elevation_map, point), atol=2e-5
        )


@pytest.mark.parametrize("holes", [0.0, 0.2])
def test_a_local_map_that_ends_at_the_border_to_the_cell(holes):
    """Level, on the grid: the local map of one leg spans the whole map, or reaches one cell beyond it."""
    layout = LegLayout(
        hips={leg: np.zeros(3) for leg in LEGS},
        nominal_feet={leg: np.array([0, 0, -0.5]) for leg in LEGS},
        resolution=0.5,
        height_range=0.85,
        foot_radius=0.03,
    )
    for cells in (39, 40, 41, 42):
        rng = np.random.default_rng(cells)
        elevation = rng.uniform(-1, 1, (cells, cells))
        elevation[rng.random(elevation.shape) < holes] = np.nan
        elevation_map = ElevationMap(elevation, 0.5)
        for shift in (0.0, 0.25, -0.25):
            for yaw in (0.0, np.pi / 2):
                pose = BasePose(shift, -shift, 0.5, yaw=yaw)
                frames = Body(layout).place(np.array([pose.as_list()]), ["LF"], {})
                found = sample_legs(elevation_map, frames.hips, frames.heading, frames.side, np.zeros((1, 2)), 0.5)[0]
                expected = layout.local_map(elevation_map, pose, "LF").heights
                # A cell exactly between two of the map's belongs to either of them, as rounding has it.
                between = (shift != 0) == (cells % 2 == 0)
                same = np.isnan(found[0]) == np.isnan(expected)
                assert same.all() or between
                np.testing.assert_allclose(found[0][same], expected[same], atol=1e-5)


def test_a_nominal_foothold_of_the_caller_with_and_without_a_height(selector):
    rng = np.random.default_rng(5)
    elevation_map = ElevationMap(rng.uniform(-0.1, 0.1, (150, 150)), 0.02)
    pose = BasePose(0.1, 0.2, 0.47, 0.05, -0.1, 2.2)
    nominal = {"RF": (0.3, 0.3), "LH": (-0.2, 0.1, 0.4), "LF": (40.0, 40.0)}
    found = selector.select(elevation_map, pose, nominal=nominal, top_k=2)
    check_same(found, reference(selector, elevation_map, pose, nominal=nominal, top_k=2))
    assert found["LH"].nominal == (-0.2, 0.1, 0.4)


@settings(deadline=None, max_examples=60)
@given(situation=situations(), count=st.integers(1, 11), data=st.data())
def test_many_poses_are_answered_as_one_by_one(selector, situation, count, data):
    """Poses spread over the map, more than one batch of them, legs in any order."""
    elevation_map, first = situation
    legs = tuple(data.draw(st.permutations(LEGS)))[: data.draw(st.integers(1, 4))]
    rng = np.random.default_rng(count)
    poses = np.tile(first.as_list(), (count, 1))
    poses[1:, :2] = elevation_map.position + rng.uniform(-0.499, 0.499, (count - 1, 2)) * elevation_map.size
    poses[1:, 3:] += rng.uniform(-0.1, 0.1, (count - 1, 3))
    nominal = {legs[0]: poses[:, :2] + 0.1}
    many = selector.select_many(elevation_map, poses, legs, nominal)
    assert many.legs == legs and len(many) == count
    for number, pose in enumerate(poses):
        options = {legs[0]: nominal[legs[0]][number]}
        single = selector.select(elevation_map, pose, legs, options)
        for column, (leg, foothold) in enumerate(single.items()):
            assert leg == legs[column]
            at = number, column
            assert many.found[at] == (foothold.status == "ok")
            np.testing.assert_allclose(many.nominal[at], foothold.nominal, atol=1e-6)
            if many.found[at]:
                second = selector.select(elevation_map, pose, legs, options, top_k=2)[leg].alternatives
                assert many.final_costs[at] == pytest.approx(foothold.final_cost, abs=TIE)
                if second and second[0].final_cost - foothold.final_cost < TIE:
                    continue
                assert tuple(many.cells[at]) == foothold.cell
                np.testing.assert_allclose(many.positions[at], foothold.position, atol=1e-6)
                assert many.costs[at] == pytest.approx(foothold.cost, abs=2e-3)
                assert many.distances[at] == pytest.approx(foothold.distance_to_nominal, abs=1e-6)
                assert many.confidences[at] == pytest.approx(foothold.confidence, abs=1e-5)
            else:
                assert np.isnan(many.positions[at]).all() and (many.cells[at] == -1).all()
                assert many.costs[at] == many.final_costs[at] == np.inf
                assert np.isnan(many.distances[at]) and many.confidences[at] == 0
