"""Laws of the embedded selector, on networks small enough to know every answer."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footsel import ElevationMap
from footsel.errors import InputError, UnknownNameError
from footsel.footholds import BasePose
from footsel.legs import LEGS, mirror_of
from footsel.runtime import FootholdSelector

POSE = (0.1, -0.05, 0.5, 0.05, -0.03, 0.7)


def rough_map(seed: int = 0, holes: float = 0.1) -> ElevationMap:
    rng = np.random.default_rng(seed)
    elevation = rng.uniform(-0.1, 0.1, (120, 120)).astype(np.float32)
    elevation[rng.random(elevation.shape) < holes] = np.nan
    return ElevationMap(elevation, 0.02)


@pytest.fixture
def selector(model_folder):
    return FootholdSelector.load(model_folder)


def answers(footholds):
    return {leg: foothold.to_dict() for leg, foothold in footholds.items()}


def test_the_pick_is_what_the_cells_say(selector):
    """select against evaluate and a plain search, for all four legs."""
    elevation_map, pose = rough_map(), BasePose.of(POSE)
    footholds = selector.select(elevation_map, POSE)
    assert tuple(footholds) == LEGS
    for leg, foothold in footholds.items():
        local = selector.layout.local_map(elevation_map, pose, leg)
        cells = selector.evaluate(local.heights, leg, pose.roll, pose.pitch)
        total = cells.cost + 160 * local.distances_to(selector.layout.nominal_xy(leg, pose))
        total[~cells.feasible] = np.inf
        assert np.isfinite(total).sum() > 5
        i, j = np.unravel_index(np.argmin(total), total.shape)
        assert foothold.cell == (i, j)
        assert foothold.final_cost == pytest.approx(total[i, j], abs=1e-3)
        np.testing.assert_allclose(foothold.position, local.positions()[i, j])
        assert foothold.confidence == pytest.approx(cells.confidence[i, j], abs=1e-6)
        assert 0 < foothold.confidence < 1


def test_flat_ground_with_equal_costs_gives_the_cell_nearest_to_the_nominal_foothold(constant_folder):
    selector = FootholdSelector.load(constant_folder(0))
    flat = ElevationMap(np.zeros((200, 200)), 0.02)
    for yaw in np.linspace(-3, 3, 7):
        pose = BasePose(0.13, -0.21, 0.47, yaw=float(yaw))
        for leg, foothold in selector.select(flat, pose).items():
            distances = selector.layout.local_map(flat, pose, leg).distances_to(foothold.nominal[:2])
            assert foothold.distance_to_nominal == pytest.approx(distances.min())
            assert foothold.distance_to_nominal <= 0.02 / np.sqrt(2) + 1e-9


def test_a_mirrored_world_gives_the_mirrored_answer(selector):
    elevation_map = rough_map(1)
    mirrored = ElevationMap(elevation_map.elevation[:, ::-1], 0.02)
    x, y, z, roll, pitch, yaw = POSE
    here = selector.select(elevation_map, POSE, top_k=3)
    there = selector.select(mirrored, (x, -y, z, -roll, pitch, -yaw), top_k=3)
    assert len({foothold.cell for foothold in here.values()}) > 1
    for leg in LEGS:
        one, other = here[leg], there[mirror_of(leg)]
        assert one.status == other.status == "ok"
        assert one.cell == (other.cell[0], 39 - other.cell[1])
        np.testing.assert_allclose(np.array(one.position) * (1, -1, 1), other.position, atol=1e-6)
        assert one.final_cost == pytest.approx(other.final_cost, abs=1e-3)
        assert len(one.alternatives) == len(other.alternatives) == 2


def test_evaluate_is_mirrored_too(selector):
    heights = np.random.default_rng(2).uniform(-0.7, -0.3, (3, 40, 40))
    heights[:, 3:9, 30:] = np.nan
    roll = np.array([0.1, -0.05, 0.0])
    for left, right in (("LF", "RF"), ("LH", "RH")):
        one, other = (
            selector.evaluate(heights, left, roll, 0.02),
            selector.evaluate(heights[..., ::-1], right, -roll, 0.02),
        )
        assert 0 < one.feasible.sum() < one.feasible.size
        for name in ("class_", "cost", "feasible", "confidence"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name)[..., ::-1], atol=1e-3)


def test_one_map_is_a_batch_of_one(selector):
    heights = np.random.default_rng(3).uniform(-0.7, -0.3, (2, 40, 40))
    batch, single = selector.evaluate(heights, "RF", 0.1, 0.0), selector.evaluate(heights[1], "RF", 0.1, 0.0)
    assert batch.cost.shape == (2, 40, 40)
    assert single.cost.shape == single.class_.shape == single.feasible.shape == (40, 40)
    np.testing.assert_allclose(batch.cost[1], single.cost, atol=1e-3)


def test_other_dtypes_and_memory_orders_are_accepted(selector):
    heights = np.random.default_rng(4).uniform(-0.7, -0.3, (40, 40)).astype(np.float32)
    expected = selector.evaluate(heights, "LF", 0, 0)
    for same in (heights.astype(np.float64), np.asfortranarray(heights), heights.tolist()):
        np.testing.assert_array_equal(selector.evaluate(same, "LF", 0, 0).cost, expected.cost)


@pytest.mark.parametrize("seed", range(5))
def test_an_unknown_cell_is_never_picked(constant_folder, seed):
    """The networks call everything feasible; nine cells in ten have no height."""
    selector = FootholdSelector.load(constant_folder(0))
    for foothold in selector.select(rough_map(seed, holes=0.9), POSE, top_k=1600).values():
        positions = [foothold.position, *(alternative.position for alternative in foothold.alternatives)]
        assert 50 < len(positions) < 350
        assert np.isfinite(positions).all()


def test_a_wholly_unknown_map_is_answered_with_none(selector):
    unknown = ElevationMap(np.full((50, 50), np.nan), 0.02)
    for foothold in selector.select(unknown, (0, 0, 0.5, 0, 0, 0)).values():
        assert foothold.status == "none"
        assert foothold.reason == "no cell of the local map is known"
        assert foothold.position is None
        assert foothold.cell is None
        assert np.isfinite(foothold.nominal).all()


def test_no_feasible_cell_is_answered_with_none(constant_folder):
    selector = FootholdSelector.load(constant_folder(13))
    for foothold in selector.select(rough_map(), POSE).values():
        assert (foothold.status, foothold.reason) == ("none", "the network calls no known cell feasible")


def test_the_map_may_have_another_cell_size(constant_folder):
    selector = FootholdSelector.load(constant_folder(0))
    for resolution in (0.01, 0.02, 0.05):
        n = round(4 / resolution)
        x = (np.arange(n) - (n - 1) / 2) * resolution
        slope = ElevationMap(np.repeat(0.2 * x[:, None], n, axis=1), resolution)
        for foothold in selector.select(slope, POSE).values():
            assert foothold.position[2] == pytest.approx(0.2 * foothold.position[0], abs=1e-5)


def test_top_k_is_in_the_order_of_final_cost(selector):
    for foothold in selector.select(rough_map(), POSE, top_k=10).values():
        costs = [foothold.final_cost, *(alternative.final_cost for alternative in foothold.alternatives)]
        assert len(costs) == 10
        assert costs == sorted(costs)


def test_only_the_legs_asked_for_in_their_order(selector):
    everything = selector.select(rough_map(), POSE)
    some = selector.select(rough_map(), POSE, legs=("RH", "LF"))
    assert tuple(some) == ("RH", "LF")
    for leg, foothold in some.items():
        assert foothold.cell == everything[leg].cell
    assert selector.select(rough_map(), POSE, legs=()) == {}


def test_verify_sees_the_candidates_in_order_until_one_is_accepted(selector):
    plain = selector.select(rough_map(), POSE, legs=("RF",), top_k=4)["RF"]
    asked = []

    def verify(leg, base_pose, cell, position):
        asked.append((leg, base_pose, cell, position))
        return len(asked) == 3

    chosen = selector.select(rough_map(), POSE, legs=("RF",), verify=verify)["RF"]
    assert len(asked) == 3
    assert [position for *_, position in asked] == [plain.position, *(a.position for a in plain.alternatives[:2])]
    assert {(leg, pose) for leg, pose, *_ in asked} == {("RF", POSE)}
    assert chosen.position == plain.alternatives[1].position
    assert chosen.cell == asked[-1][2]


def test_verify_may_refuse_everything(constant_folder):
    selector = FootholdSelector.load(constant_folder(0))
    flat = ElevationMap(np.zeros((200, 200)), 0.02)
    foothold = selector.select(flat, (0, 0, 0.5, 0, 0, 0), legs=["LF"], verify=lambda *_: False)["LF"]
    assert (foothold.status, foothold.reason) == ("none", "none of 1600 candidates passed the verification")


def test_a_nominal_foothold_of_the_caller(constant_folder):
    selector = FootholdSelector.load(constant_folder(0))
    flat = ElevationMap(np.zeros((200, 200)), 0.02)
    pose = (0, 0, 0.5, 0, 0, 0)
    own = selector.select(flat, pose)
    given = selector.select(flat, pose, nominal={"LF": (0.51, 0.15), "RH": (-0.3, -0.31, 0.07)})
    assert given["LF"].nominal == (0.51, 0.15, 0.0)
    assert given["RH"].nominal == (-0.3, -0.31, 0.07)
    for leg in ("LF", "RH"):
        assert np.linalg.norm(np.subtract(given[leg].position, given[leg].nominal)[:2]) < 0.015
        assert given[leg].position != own[leg].position
    for leg in ("RF", "LH"):
        assert given[leg] == own[leg]


def test_two_threads_share_a_selector(selector):
    maps = [rough_map(seed) for seed in range(6)]
    expected = [answers(selector.select(elevation_map, POSE)) for elevation_map in maps]
    with ThreadPoolExecutor(2) as threads:
        for _ in range(5):
            found = threads.map(lambda elevation_map: answers(selector.select(elevation_map, POSE)), maps)
            assert list(found) == expected


def test_timing_is_that_of_the_call(selector):
    footholds, timing = selector.select_timed(rough_map(), POSE)
    assert answers(footholds) == answers(selector.select(rough_map(), POSE))
    assert 0 < timing.network < timing.total < 1000


def test_contract_attributes(selector, anymal_layout):
    assert selector.robot == "anymal_b"
    assert selector.layout.to_dict() == anymal_layout.to_dict()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"base_pose": (50, 0, 0.5, 0, 0, 0)}, "the base at x=50 y=0 is off the map; the map spans x -1.2..1.2"),
        ({"base_pose": (0, 0, 0.5)}, "give six finite numbers"),
        ({"base_pose": "here"}, "is not numeric"),
        ({"elevation_map": np.zeros((9, 9))}, "elevation map is a ndarray; give a footsel.ElevationMap"),
        ({"top_k": 0}, "top_k is 0; give a whole number of 1 or more"),
        ({"top_k": 1.5}, "top_k is 1.5"),
        ({"nominal": {"LF": (0, np.nan)}}, "nominal foothold of LF is .*; give world"),
        ({"nominal": {"LF": (0, 1, 2, 3)}}, "nominal foothold of LF"),
        ({"nominal": {"LF": "far"}}, "nominal foothold of LF is 'far'; give world"),
    ],
)
def test_what_makes_no_sense_is_refused(selector, arguments, words):
    with pytest.raises(InputError, match=words):
        selector.select(**{"elevation_map": rough_map(), "base_pose": POSE, **arguments})


def test_an_unknown_leg_lists_the_legs(selector):
    with pytest.raises(UnknownNameError, match="unknown leg 'FL'; choose from: LF, RF, LH, RH"):
        selector.select(rough_map(), POSE, legs=("FL",))
    with pytest.raises(UnknownNameError, match="unknown leg 'FL'"):
        selector.select(rough_map(), POSE, nominal={"FL": (0, 0)})
    with pytest.raises(UnknownNameError, match="unknown leg 'FL'"):
        selector.evaluate(np.zeros((40, 40)), "FL", 0, 0)


@pytest.fixture(scope="module")
def shared_selector(tmp_path_factory, handmade, anymal_layout):
    files = {
        f"{pair}.onnx": handmade.random_model(handmade.contract(anymal_layout, pair), 0) for pair in ("front", "hind")
    }
    return FootholdSelector.load(handmade.write_folder(tmp_path_factory.mktemp("shared") / "model", files))


@settings(deadline=None, max_examples=60)
@given(shape=st.lists(st.sampled_from([0, 1, 2, 39, 40, 41]), max_size=4))
def test_only_40_by_40_heights_are_accepted(shared_selector, shape):
    heights = np.full(shape, -0.5)
    good = len(shape) in (2, 3) and shape[-2:] == [40, 40] and shape[0] > 0
    if good:
        assert shared_selector.evaluate(heights, "LF", 0.0, 0.0).cost.shape == tuple(shape)
    else:
        with pytest.raises(InputError, match="local heights have shape"):
            shared_selector.evaluate(heights, "LF", 0.0, 0.0)


@settings(deadline=None, max_examples=60)
@given(pose=st.lists(st.floats(width=32), min_size=6, max_size=6))
def test_any_pose_is_answered_or_refused(shared_selector, pose):
    try:
        footholds = shared_selector.select(rough_map(), pose)
    except InputError:
        assert not np.isfinite(pose).all() or max(abs(pose[0]), abs(pose[1])) >= 1.2 or np.abs(pose).max() >= 1e9
    else:
        for foothold in footholds.values():
            assert (foothold.status == "ok") == (foothold.position is not None)
            assert foothold.position is None or np.isfinite(foothold.position).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"local_heights": np.full((40, 40), np.inf)}, "infinite values; mark unknown cells with NaN"),
        ({"local_heights": np.full((40, 40), 1e300)}, "infinite values"),
        ({"local_heights": [["high"] * 40] * 40}, "cannot read the local heights as numbers"),
        ({"roll": np.nan}, "roll holds a value that is not finite"),
        ({"pitch": [0.0, 0.1]}, "pitch has shape"),
        ({"roll": "left"}, "cannot read the roll as numbers"),
    ],
)
def test_what_evaluate_refuses(shared_selector, change, words):
    with pytest.raises(InputError, match=words):
        shared_selector.evaluate(**{"local_heights": np.zeros((40, 40)), "leg": "LF", "roll": 0, "pitch": 0, **change})
