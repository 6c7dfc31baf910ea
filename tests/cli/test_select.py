"""`footsel select`: its JSON, with a network and with the oracle."""

import json
import math

import numpy as np
import pytest
from PIL import Image

from footsel import ElevationMap
from footsel.footholds import LegLayout
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector

FOOTHOLD_KEYS = {
    "status",
    "reason",
    "position",
    "cell",
    "cost",
    "class",
    "final_cost",
    "nominal",
    "distance_to_nominal",
    "confidence",
    "alternatives",
}


def strict_json(text):
    """JSON, without the NaN that Python's reader would let through."""

    def refuse(word):
        raise ValueError(f"{word} is not JSON")

    return json.loads(text, parse_constant=refuse)


def test_the_answer_is_the_runtimes(footsel, bumpy_map, model_folder):
    pose = ["0.1", "-0.05", "0.55", "-1e-05", "0.02", "-.5"]
    outcome = footsel("select", bumpy_map, "--pose", *pose, "--model", model_folder)
    assert outcome.code == 0 and outcome.err == ""
    answer = strict_json(outcome.out)
    assert list(answer) == ["robot", "selector", "pose", "footholds", "time_ms"]
    assert (answer["robot"], answer["selector"]) == ("anymal_b", "cnn")
    assert answer["pose"] == [0.1, -0.05, 0.55, -1e-05, 0.02, -0.5]
    expected = FootholdSelector.load(model_folder).select(ElevationMap.load(bumpy_map), answer["pose"], top_k=3)
    assert answer["footholds"] == {
        leg: strict_json(json.dumps(foothold.to_dict())) for leg, foothold in expected.items()
    }
    assert list(answer["footholds"]) == list(LEGS)
    for foothold in answer["footholds"].values():
        assert set(foothold) == FOOTHOLD_KEYS
    assert 0 < answer["time_ms"]["network"] < answer["time_ms"]["total"]


def test_legs_and_top_k(footsel, bumpy_map, constant_folder, level_pose):
    outcome = footsel(
        "select", bumpy_map, *level_pose, "--model", constant_folder(2), "--legs", "RH", "LF", "--top-k", 5
    )
    footholds = strict_json(outcome.out)["footholds"]
    assert list(footholds) == ["RH", "LF"]
    for foothold in footholds.values():
        assert foothold["status"] == "ok" and foothold["class"] == 2 and len(foothold["alternatives"]) == 4
        costs = [foothold["final_cost"], *(each["final_cost"] for each in foothold["alternatives"])]
        assert costs == sorted(costs)


def test_right_legs_stand_on_the_right(footsel, bumpy_map, constant_folder, level_pose):
    footholds = strict_json(footsel("select", bumpy_map, *level_pose, "--model", constant_folder(0)).out)["footholds"]
    for leg, foothold in footholds.items():
        x, y, _ = foothold["position"]
        assert (x > 0) == leg.endswith("F") and (y > 0) == leg.startswith("L")


def test_no_foothold_is_an_answer(footsel, bumpy_map, constant_folder, level_pose):
    outcome = footsel("select", bumpy_map, *level_pose, "--model", constant_folder(13))
    assert outcome.code == 0
    for foothold in strict_json(outcome.out)["footholds"].values():
        assert foothold["status"] == "none" and foothold["reason"]
        assert foothold["position"] is None and foothold["cell"] is None and foothold["alternatives"] == []


def test_unknown_ground_is_an_answer(footsel, tmp_path, constant_folder):
    elevation = np.full((300, 300), np.nan)
    elevation[:20, :20] = 0.0
    ElevationMap(elevation, 0.02).save(tmp_path / "dark.npz")
    select = ("select", tmp_path / "dark.npz", "--model", constant_folder(0), "--pose", "1", "1")
    outcome = footsel(*select, "0.5", "0", "0", "0")
    assert outcome.code == 0
    for foothold in strict_json(outcome.out)["footholds"].values():
        assert foothold["status"] == "none" and foothold["reason"] == "no cell of the local map is known"
    assert footsel(*select, "auto", "0", "0", "0").complains("auto", "metres")


@pytest.mark.parametrize("selector", ["oracle", "nominal", "terrain_only", "cnn+verify"])
def test_every_selector_answers(footsel, bumpy_map, constant_folder, level_pose, selector):
    outcome = footsel("select", bumpy_map, *level_pose, "--selector", selector, "--model", constant_folder(1))
    answer = strict_json(outcome.out)
    assert outcome.code == 0 and answer["selector"] == selector
    assert {foothold["status"] for foothold in answer["footholds"].values()} == {"ok"}
    assert (answer["time_ms"]["network"] is None) == (selector != "cnn+verify")
    for foothold in answer["footholds"].values():
        assert math.dist(foothold["position"][:2], foothold["nominal"][:2]) < 0.4


def test_plot(footsel, bumpy_map, constant_folder, level_pose, tmp_path):
    plot = tmp_path / "picks.png"
    assert footsel("select", bumpy_map, *level_pose, "--model", constant_folder(0), "--plot", plot).code == 0
    with Image.open(plot) as image:
        assert image.format == "PNG" and min(image.size) > 300
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bumpy.npz", "constant0", "picks.png"]


def test_a_model_of_another_robot_is_refused(
    footsel, bumpy_map, level_pose, handmade, anymal_layout: LegLayout, tmp_path
):
    files = {
        f"{pair}.onnx": handmade.constant_model(handmade.contract(anymal_layout, pair, robot="hyq"))
        for pair in ("front", "hind")
    }
    folder = handmade.write_folder(tmp_path / "hyq", files)
    assert footsel("select", bumpy_map, *level_pose, "--model", folder).complains("hyq", "anymal_b")
