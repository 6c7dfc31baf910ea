"""Requests that make no sense are answered in words; an answer of "none" is none of them."""

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.errors import InputError
from footsel.runtime import FootholdSelector

POSE = (0.1, -0.05, 0.5, 0.05, -0.03, 0.7)
FLAT = np.zeros((100, 100), np.float32)


@pytest.fixture
def ask(cpp, model_folder, case):
    """The answer to one request on a flat map, or on another one."""

    def asked(pose=POSE, elevation=FLAT, resolution=0.02, position=(0.0, 0.0), **changes):
        (answer,) = cpp.select(model_folder, [case(None, pose, raw=(elevation, resolution, position), **changes)])
        return answer

    return asked


@pytest.mark.parametrize("number", range(6))
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_pose_that_is_not_finite(ask, number, value):
    pose = [*POSE]
    pose[number] = value
    assert "give six finite numbers: x y z roll pitch yaw, in m and rad" in ask(tuple(pose))["error"]


@pytest.mark.parametrize("x", [-5.0, 1.0001, 9e8])
def test_base_off_the_map_says_what_python_says(ask, model_folder, x):
    selector = FootholdSelector.load(model_folder)
    with pytest.raises(InputError) as python:
        selector.select(ElevationMap(FLAT, 0.02), (x, *POSE[1:]))
    assert ask((x, *POSE[1:]))["error"] == str(python.value)


def test_map_in_another_galaxy(ask):
    assert "give its position in metres" in ask((1e12, *POSE[1:]), position=(1e12, 0.0))["error"]


def test_null_map(ask):
    assert ask(null=True)["error"] == "the elevation map is null; give its heights"


@pytest.mark.parametrize("shape", [(0, 0), (1, 1), (1, 100), (100, 1), (0, 100)])
def test_map_that_is_too_small(ask, shape):
    error = ask(elevation=np.zeros(shape, np.float32))["error"]
    assert error == f"elevation has shape {shape}; expected at least 2x2 cells"


@pytest.mark.parametrize("resolution", [0.0, -0.02, np.nan, np.inf])
def test_resolution_that_makes_no_map(ask, resolution):
    assert "expected a cell side above 0 m" in ask(resolution=resolution)["error"]


@pytest.mark.parametrize("resolution", [1e-6, 20_000.0])
def test_cells_that_no_leg_can_use(ask, resolution):
    assert "m wide; give its resolution in metres" in ask(resolution=resolution)["error"]


def test_position_that_is_not_finite(ask):
    assert "expected two finite numbers, world xy in metres" in ask(position=(0.0, np.nan))["error"]


@pytest.mark.parametrize("height", [np.inf, -np.inf, np.finfo(np.float32).max])
def test_infinite_heights_where_a_leg_looks(ask, height):
    elevation = FLAT.copy()
    elevation[66, 60] = height
    if np.isinf(height):
        assert ask(elevation=elevation)["error"] == "elevation holds infinite heights; mark unknown cells with NaN"
    else:
        assert "footholds" in ask(elevation=elevation)


def test_terrain_far_from_every_leg_is_said(ask):
    """A map in millimetres, or in another frame."""
    assert ask()["far_from_terrain"] == 0
    assert ask(elevation=FLAT + 500)["far_from_terrain"] == 1
    assert ask(elevation=FLAT + np.nan)["far_from_terrain"] == 0


def test_unknown_map_is_an_answer(ask):
    footholds = ask(elevation=np.full((100, 100), np.nan, np.float32))["footholds"]
    assert {foothold["reason"] for foothold in footholds.values()} == {"no cell of the local map is known"}
    assert {foothold["status"] for foothold in footholds.values()} == {"none"}
    assert {foothold["position"] for foothold in footholds.values()} == {None}


def test_tiny_map_is_an_answer(ask, model_folder):
    """Four cells, which the corners of the legs' local maps see."""
    pose, elevation = (0.0, 0.0, 0.5, 0, 0, 0), np.zeros((2, 2), np.float32)
    expected = FootholdSelector.load(model_folder).select(ElevationMap(elevation, 0.02), pose)
    found = ask(pose, elevation=elevation)["footholds"]
    assert {leg: foothold["status"] for leg, foothold in found.items()} == {
        leg: foothold.status for leg, foothold in expected.items()
    }


@pytest.mark.parametrize("point", [(np.nan, 0.0), (0.0, np.inf), (0.0, 0.0, np.nan)])
def test_nominal_foothold_that_is_not_finite(ask, point):
    assert "nominal foothold of RH is" in ask(nominal={"RH": point})["error"]
    # Nobody asks for that leg.
    assert "footholds" in ask(nominal={"RH": point}, legs=("LF",))


@pytest.mark.parametrize("top_k", [0, 17, 1e15])
def test_top_k_out_of_range(ask, top_k):
    assert "give a whole number from 1 to 16" in ask(top_k=top_k)["error"]


@pytest.mark.parametrize("max_distance", [-0.1, np.nan])
def test_max_distance_that_makes_no_sense(ask, max_distance):
    assert "give 0 m or more" in ask(max_distance=max_distance)["error"]


@pytest.mark.parametrize("hysteresis", [-1.0, np.nan])
def test_hysteresis_that_makes_no_sense(ask, hysteresis):
    assert "give a final cost of 0 or more" in ask(hysteresis=hysteresis)["error"]


def test_previous_foothold_that_is_not_finite(ask):
    assert "previous foothold of LH is" in ask(previous={"LH": (0.0, np.nan)})["error"]


def test_verify_that_throws(ask):
    answer = ask(verify=3)
    assert answer["error"] == "the verify callback threw: no verdict"


def test_no_legs(ask):
    assert ask(legs=())["footholds"] == {}


def test_max_distance(cpp, constant_folder, case):
    """Every cell costs the same, but the nearest known ground is 30 cm from the nominal foothold."""
    elevation = np.full((200, 200), np.nan, np.float32)
    elevation[134:] = 0.0  # x above 0.68, where LF's local map reaches and its nominal foothold (x = 0.36) is not
    raw = (elevation, 0.02, (0.0, 0.0))
    pose = (0.0, 0.0, 0.48, 0, 0, 0)
    far, near = (case(None, pose, ("LF",), max_distance=most, raw=raw) for most in (0.4, 0.2))
    far, near = cpp.select(constant_folder(0), [far, near])
    found = far["footholds"]["LF"]
    assert found["status"] == "ok" and 0.25 < found["distance_to_nominal"] <= 0.4
    assert near["footholds"]["LF"]["reason"] == "no feasible cell lies within 0.2 m of the nominal foothold"
