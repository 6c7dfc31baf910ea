"""Every selector behind one interface, on the same maps."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from footsel.comparison.palette import MARKS
from footsel.comparison.report import DESCRIPTIONS
from footsel.errors import InputError, ModelError, UnknownNameError
from footsel.footholds import DISTANCE_WEIGHT, BasePose
from footsel.legs import LEGS, mirror_of
from footsel.oracle import Oracle
from footsel.oracle.terrain_cost import terrain_costs
from footsel.selectors import SELECTORS, Selector, make_selector
from footsel.terrain import ElevationMap
from footsel.terrain.courses import make_course

STANDING = BasePose(0.1, -0.2, 0.47, 0.05, -0.04, 0.6)


@pytest.fixture(params=SELECTORS)
def selector(request: pytest.FixtureRequest, constant_folder: Callable[[int], Path]) -> Selector:
    """Each by its name; the networks are handmade and call every cell equally good."""
    return make_selector(request.param, model=constant_folder(3))


@pytest.fixture(scope="module")
def stones() -> ElevationMap:
    return make_course("stones", 4)


def test_unknown_cells_are_never_chosen(selector: Selector) -> None:
    rng = np.random.default_rng(0)
    elevation = make_course("rough", 1).elevation.copy()
    elevation[rng.random(elevation.shape) < 0.5] = np.nan
    elevation_map = ElevationMap(elevation, 0.02)
    for _ in range(10):
        x, y, yaw = rng.uniform([-2, -2, -np.pi], [2, 2, np.pi])
        for foothold in selector.select(elevation_map, BasePose(x, y, 0.47, 0, 0, yaw)).values():
            if foothold.position is not None:
                assert not np.isnan(elevation_map.sample(foothold.position[:2]))


def test_on_unknown_ground_the_answer_is_none_with_a_reason(selector: Selector) -> None:
    elevation_map = ElevationMap(np.full((200, 200), np.nan), 0.02)
    for foothold in selector.select(elevation_map, STANDING).values():
        assert foothold.status == "none" and foothold.reason
        assert foothold.position is None and foothold.cell is None


def test_off_the_map_is_an_error(selector: Selector, stones: ElevationMap) -> None:
    with pytest.raises(InputError, match="off the map"):
        selector.select(stones, BasePose(50.0, 0.0, 0.5))


def test_flat_ground_mirrors(selector: Selector) -> None:
    """Flat ground has no diagonals to turn, so left and right answer alike."""
    flat = ElevationMap(np.zeros((200, 200)), 0.02)
    # Off the middle between two cells, where the nearer of them is a matter of rounding.
    nominal = {"LF": (0.36, 0.2), "RF": (0.36, -0.2), "LH": (-0.36, 0.2), "RH": (-0.36, -0.2)}
    footholds = selector.select(flat, BasePose(0.0, 0.0, 0.47), nominal=nominal)
    for leg in LEGS:
        here, there = footholds[leg].position, footholds[mirror_of(leg)].position
        assert here is not None and there is not None
        np.testing.assert_allclose(here, (there[0], -there[1], there[2]), atol=1e-9)


def test_only_the_legs_asked_for_answer(selector: Selector, stones: ElevationMap) -> None:
    assert list(selector.select(stones, STANDING, legs=("RH", "LF"))) == ["RH", "LF"]


def test_nominal_has_one_foothold_and_no_choice(stones: ElevationMap) -> None:
    """A planner that could choose among cells by what the map says of them would not be without perception."""
    for foothold in make_selector("nominal").select(stones, STANDING, top_k=1600).values():
        assert foothold.status == "ok" and not foothold.alternatives


def test_nominal_picks_the_nearest_known_cell() -> None:
    selector = make_selector("nominal")
    elevation = np.zeros((200, 200), dtype=np.float32)
    for foothold in selector.select(ElevationMap(elevation, 0.02), STANDING).values():
        assert foothold.distance_to_nominal is not None
        assert foothold.distance_to_nominal <= 0.01 * np.sqrt(2) + 1e-9
    elevation[:] = np.nan
    elevation[:100] = 0.0
    answers = selector.select(ElevationMap(elevation, 0.02), BasePose(0.0, 0.0, 0.47))
    assert {leg: answers[leg].status for leg in LEGS} == {"LF": "none", "RF": "none", "LH": "ok", "RH": "ok"}


def test_terrain_only_minimises_its_cost(stones: ElevationMap) -> None:
    selector = make_selector("terrain_only")
    for leg, foothold in selector.select(stones, STANDING).items():
        local_map = selector.layout.local_map(stones, STANDING, leg)
        cost = np.minimum(255 * terrain_costs(local_map.heights, local_map.resolution), 254)
        final = cost + DISTANCE_WEIGHT * local_map.distances_to(selector.layout.nominal_xy(leg, STANDING))
        assert foothold.final_cost == pytest.approx(np.nanmin(final))


def test_oracle_picks_its_cheapest_feasible_cell(stones: ElevationMap) -> None:
    selector, oracle = make_selector("oracle"), Oracle.load("anymal_b")
    for leg, foothold in selector.select(stones, STANDING).items():
        local_map = selector.layout.local_map(stones, STANDING, leg)
        label = oracle.label(local_map, leg, STANDING.roll, STANDING.pitch)
        final = label.cost + DISTANCE_WEIGHT * local_map.distances_to(selector.layout.nominal_xy(leg, STANDING))
        if foothold.cell is None:
            assert not label.feasible.any()
        else:
            assert label.feasible[foothold.cell]
            assert foothold.final_cost == pytest.approx(final[label.feasible].min())


def test_oracle_says_what_stood_in_the_way() -> None:
    deep = ElevationMap(np.full((200, 200), -3.0), 0.02)
    foothold = make_selector("oracle").select(deep, STANDING, legs=("LF",))["LF"]
    assert foothold.reason == "no known cell is feasible: 1600 kinematic range"


def test_verified_network_agrees_with_the_oracle(constant_folder: Callable[[int], Path]) -> None:
    """The handmade network knows nothing, so what the verification leaves is the oracle's doing."""
    selector, oracle = make_selector("cnn+verify", model=constant_folder(3)), Oracle.load("anymal_b")
    rng = np.random.default_rng(2)
    for family in ("pillars", "stones", "stairs"):
        course = make_course(family, 7)
        x, y, yaw = rng.uniform([-2, -2, -np.pi], [2, 2, np.pi])
        pose = BasePose(x, y, selector.layout.ground_height(course, x, y, yaw) + 0.45, 0.1, 0.1, yaw)
        for leg, foothold in selector.select(course, pose).items():
            feasible = oracle.label(selector.layout.local_map(course, pose, leg), leg, 0.1, 0.1).feasible
            assert (foothold.cell is None) == (not feasible.any())
            assert foothold.cell is None or feasible[foothold.cell]


def test_the_report_can_draw_and_describe_every_selector() -> None:
    assert set(MARKS) == set(DESCRIPTIONS) == set(SELECTORS)
    assert len({(mark.marker, mark.colour) for mark in MARKS.values()}) == len(SELECTORS)


def test_eight_bits_are_asked_for_by_name(model_folder: Path) -> None:
    with pytest.raises(ModelError, match=r"does not list front.int8.onnx; variants of this model: float32"):
        make_selector("cnn:int8", model=model_folder)


def test_unknown_selector_lists_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match=r"cnn\+verify"):
        make_selector("best")
