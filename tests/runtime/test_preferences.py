"""Hysteresis towards the previous foothold, and a largest distance from the nominal one."""

import dataclasses
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footsel import ElevationMap
from footsel.errors import InputError, UnknownNameError
from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector

POSE = (0.1, -0.05, 0.5, 0.05, -0.03, 0.7)


def rough_map(seed: int = 0, holes: float = 0.1) -> ElevationMap:
    rng = np.random.default_rng(seed)
    elevation = rng.uniform(-0.1, 0.1, (120, 120)).astype(np.float32)
    elevation[rng.random(elevation.shape) < holes] = np.nan
    return ElevationMap(elevation, 0.02)


@pytest.fixture(scope="module")
def selector(tmp_path_factory, handmade, anymal_layout):
    files = {
        f"{pair}.onnx": handmade.random_model(handmade.contract(anymal_layout, pair), seed)
        for seed, pair in enumerate(("front", "hind"))
    }
    return FootholdSelector.load(handmade.write_folder(tmp_path_factory.mktemp("preferences") / "model", files))


def candidates(selector, elevation_map, leg, **options):
    """The position and final cost of every cell that may be chosen, cheapest first."""
    foothold = selector.select(elevation_map, POSE, [leg], top_k=1600, **options)[leg]
    return [(foothold.position, foothold.final_cost), *((a.position, a.final_cost) for a in foothold.alternatives)]


@pytest.mark.parametrize("leg", LEGS)
def test_the_previous_foothold_is_kept_until_another_is_better_by_more(selector, leg):
    elevation_map = rough_map()
    (best, cheapest), *others = candidates(selector, elevation_map, leg)
    for position, cost in others[::40]:
        gap = cost - cheapest
        for hysteresis, expected in ((gap + 0.01, position), (max(gap - 0.01, 0), best)):
            found = selector.select(elevation_map, POSE, [leg], previous={leg: position}, hysteresis=hysteresis)[leg]
            np.testing.assert_allclose(found.position, expected, atol=1e-6)
        # A kept foothold says its own cost, not one with the bonus.
        kept = selector.select(elevation_map, POSE, [leg], previous={leg: position}, hysteresis=np.inf)[leg]
        assert kept.final_cost == pytest.approx(cost, abs=1e-3)
        assert kept.final_cost == pytest.approx(kept.cost + 160 * kept.distance_to_nominal, abs=1e-6)


def test_the_previous_foothold_takes_no_one_s_place_among_the_alternatives(selector):
    """It is one of the cheapest cells itself; the others are all named all the same."""
    elevation_map = rough_map()
    ranked = candidates(selector, elevation_map, "LF")
    found = selector.select(elevation_map, POSE, ["LF"], top_k=3, previous={"LF": ranked[1][0]}, hysteresis=0.0)["LF"]
    named = [found.position, *(alternative.position for alternative in found.alternatives)]
    np.testing.assert_allclose(named, [position for position, _ in ranked[:3]], atol=1e-6)


def test_an_answer_can_be_given_back_as_it_is(selector):
    """The dict of the last call; a leg that had none, or is not asked for, does not matter."""
    first = selector.select(rough_map(), POSE)
    again = selector.select(rough_map(), POSE, previous=first)
    for leg in LEGS:
        assert again[leg].cell == first[leg].cell
        assert again[leg].position[:2] == first[leg].position[:2]
        np.testing.assert_allclose(again[leg].position, first[leg].position, atol=1e-6)
    none = selector.select(ElevationMap(np.full((90, 90), np.nan), 0.02), POSE)
    assert none["LF"].status == "none"
    assert selector.select(rough_map(), POSE, previous={**none, "RH": None}) == first
    assert selector.select(rough_map(), POSE, legs=["LF"], previous=first) == {"LF": again["LF"]}


def test_a_kept_foothold_does_not_creep_as_the_base_moves(selector):
    """The grid of the local map moves with the base; the foothold stays where it is, its height read anew."""
    rng = np.random.default_rng(3)
    elevation_map = rough_map(holes=0)
    footholds = start = selector.select(elevation_map, POSE)
    for step in range(40):
        raised = ElevationMap(elevation_map.elevation + 0.001 * step, 0.02)
        pose = BasePose(*np.add(POSE, rng.uniform(-0.03, 0.03, 6)))
        footholds = selector.select(raised, pose, previous=footholds, hysteresis=np.inf)
    still = [leg for leg in LEGS if np.allclose(footholds[leg].position[:2], start[leg].position[:2], rtol=0, atol=0)]
    assert still
    for leg in still:
        x, y, z = footholds[leg].position
        assert z == pytest.approx(float(raised.sample((x, y))), abs=1e-6)


def test_what_may_not_be_chosen_is_not_kept(selector, constant_folder):
    elevation_map = rough_map(holes=0)
    chosen = selector.select(elevation_map, POSE, ["LF"])["LF"]
    x, y, _ = chosen.position
    cells = selector.evaluate(
        selector.layout.local_map(elevation_map, BasePose.of(POSE), "LF").heights, "LF", 0.05, -0.03
    )
    local = selector.layout.local_map(elevation_map, BasePose.of(POSE), "LF")
    i, j = np.argwhere(~cells.feasible)[0]
    infeasible = local.positions()[i, j]
    hole = elevation_map.elevation.copy()
    u, v = np.round(elevation_map.fractional_index((x, y))).astype(int)
    hole[u, v] = np.nan
    for previous, terrain in (
        ((x + 5, y), elevation_map),  # beyond the leg's map
        ((1e8, -1e8), elevation_map),
        (infeasible, elevation_map),
        ((x, y), ElevationMap(hole, 0.02)),  # its ground became unknown
    ):
        found = selector.select(terrain, POSE, ["LF"], previous={"LF": previous}, hysteresis=np.inf)
        assert found == selector.select(terrain, POSE, ["LF"])
    nowhere = FootholdSelector.load(constant_folder(13))
    assert nowhere.select(elevation_map, POSE, ["LF"], previous={"LF": (x, y)})["LF"].status == "none"


def test_a_kept_foothold_passes_the_verification_first(selector):
    elevation_map = rough_map()
    ranked = candidates(selector, elevation_map, "RF")
    previous = ranked[50][0]
    asked = []

    def verify(_, __, cell, position):
        asked.append((cell, position))
        return len(asked) > 1

    options = {"previous": {"RF": previous}, "hysteresis": np.inf, "verify": verify}
    found = selector.select(elevation_map, POSE, ["RF"], **options)["RF"]
    np.testing.assert_allclose([position for _, position in asked], [previous, ranked[0][0]], atol=1e-6)
    assert found.position == ranked[0][0]
    assert len({cell for cell, _ in asked}) == 2


def test_alternatives_do_not_repeat_the_kept_foothold(selector):
    elevation_map = rough_map()
    ranked = candidates(selector, elevation_map, "LH")
    for place in (0, 2, 30):
        previous = {"LH": ranked[place][0]}
        found = selector.select(elevation_map, POSE, ["LH"], top_k=5, previous=previous, hysteresis=np.inf)["LH"]
        positions = [found.position, *(a.position for a in found.alternatives)]
        expected = [ranked[place][0], *(position for position, _ in ranked[:5] if position != ranked[place][0])][:5]
        np.testing.assert_allclose(positions, expected, atol=1e-6)


@settings(deadline=None, max_examples=60)
@given(max_distance=st.floats(0, 0.8), leg=st.sampled_from(LEGS), seed=st.integers(0, 5))
def test_no_pick_is_farther_than_asked(selector, max_distance, leg, seed):
    """And the picks are those of all that lie nearer."""
    elevation_map = rough_map(seed)
    near = candidates(selector, elevation_map, leg)
    found = selector.select(elevation_map, POSE, [leg], top_k=1600, max_distance=max_distance)[leg]
    nominal = np.array(found.nominal[:2])
    near = [position for position, _ in near if np.linalg.norm(np.array(position[:2]) - nominal) <= max_distance]
    if found.status == "none":
        assert not near
        assert found.reason == f"no feasible cell lies within {max_distance:g} m of the nominal foothold"
    else:
        assert found.distance_to_nominal <= max_distance
        np.testing.assert_allclose([found.position, *(a.position for a in found.alternatives)], near)


def test_a_limit_that_excludes_the_previous_foothold(selector):
    elevation_map = rough_map()
    far = max(candidates(selector, elevation_map, "LF"), key=lambda each: each[1])[0]
    found = selector.select(elevation_map, POSE, ["LF"], previous={"LF": far}, hysteresis=np.inf, max_distance=0.15)
    assert found == selector.select(elevation_map, POSE, ["LF"], max_distance=0.15)


def test_reasons_do_not_blame_the_limit(constant_folder):
    nowhere = FootholdSelector.load(constant_folder(13))
    foothold = nowhere.select(rough_map(), POSE, ["LF"], max_distance=0.1)["LF"]
    assert foothold.reason == "the network calls no known cell feasible"


def test_the_best_of_many_poses(selector, constant_folder):
    elevation_map = rough_map()
    poses = np.array(POSE) + np.random.default_rng(0).uniform(-0.05, 0.05, (20, 6))
    many = selector.select_many(elevation_map, poses)
    singles = [sum(f.final_cost for f in selector.select(elevation_map, pose).values()) for pose in poses]
    np.testing.assert_allclose(many.pose_costs, singles, atol=1e-2)
    assert many.best_pose() == int(np.argmin(singles))
    assert many.best_pose() == selector.select_many(elevation_map, poses, max_distance=5.0).best_pose()
    nowhere = FootholdSelector.load(constant_folder(13)).select_many(elevation_map, poses)
    assert nowhere.best_pose() is None and np.isinf(nowhere.pose_costs).all() and not nowhere.found.any()


def test_threads_share_the_poses_and_change_no_answer(selector, monkeypatch):
    elevation_map = rough_map()
    poses = np.array(POSE) + np.random.default_rng(1).uniform(-0.05, 0.05, (70, 6))
    nominal = {"LF": np.random.default_rng(2).uniform(0.1, 0.4, (70, 2))}
    alone = selector.select_many(elevation_map, poses, nominal=nominal)
    workers = set()
    answers = FootholdSelector._answers

    def noted(*arguments):
        workers.add(threading.get_ident())
        return answers(*arguments)

    monkeypatch.setattr(FootholdSelector, "_answers", noted)
    shared = selector.select_many(elevation_map, poses, nominal=nominal, threads=3)
    assert threading.get_ident() not in workers and 1 <= len(workers) <= 3
    for field in dataclasses.fields(alone):
        np.testing.assert_array_equal(getattr(shared, field.name), getattr(alone, field.name))


def test_no_poses_and_no_legs(selector):
    for poses, legs in ((np.empty((0, 6)), LEGS), ([POSE], ()), (np.empty((0, 6)), ())):
        many = selector.select_many(rough_map(), poses, legs)
        assert len(many) == len(poses) and many.legs == legs
        assert many.positions.shape == (len(poses), len(legs), 3)
        assert many.best_pose() is None or not legs


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"hysteresis": -1}, "hysteresis is -1; give a final cost of 0 or more"),
        ({"hysteresis": float("nan")}, "hysteresis is nan"),
        ({"hysteresis": "much"}, "hysteresis is 'much'"),
        ({"max_distance": -0.1}, "max_distance is -0.1; give metres, or None"),
        ({"previous": {"LF": (0, float("nan"))}}, "previous foothold of LF is .*; give world"),
        ({"previous": {"LF": "there"}}, "previous foothold of LF is 'there'"),
    ],
)
def test_what_makes_no_sense_is_refused(selector, arguments, words):
    with pytest.raises(InputError, match=words):
        selector.select(rough_map(), POSE, **arguments)
    with pytest.raises(UnknownNameError):
        selector.select(rough_map(), POSE, previous={"FL": None})


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"base_poses": POSE}, r"base poses have shape \(6,\); give \(n, 6\)"),
        ({"base_poses": [POSE, (*POSE[:5], np.inf)]}, "base pose 1 is .*; give finite numbers"),
        ({"base_poses": [POSE, (9, *POSE[1:])]}, "the base at x=9 y=-0.05 is off the map"),
        ({"base_poses": [["x"] * 6]}, "cannot read the base poses as numbers"),
        ({"nominal": {"LF": np.zeros((3, 2))}}, "nominal foothold of LF is of shape"),
        ({"elevation_map": np.zeros((50, 50))}, "give a footsel.ElevationMap"),
        ({"threads": 0}, "threads is 0; give a whole number of 1 or more"),
        ({"threads": 1.5}, "threads is 1.5"),
    ],
)
def test_what_select_many_refuses(selector, arguments, words):
    with pytest.raises(InputError, match=words):
        selector.select_many(**{"elevation_map": rough_map(), "base_poses": [POSE, POSE], **arguments})
