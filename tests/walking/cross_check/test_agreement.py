"""The oracle's collisions are PyBullet's but for a hair's breadth, and a fault would show."""

import json
from pathlib import Path

import numpy as np
import pytest

from footsel.terrain import LocalMap
from footsel.walking.cross_check import __main__ as command
from footsel.walking.cross_check.agreement import Agreement, Disagreement, check_source
from footsel.walking.cross_check.bullet_engine import BulletEngine
from footsel.walking.cross_check.engine import Vector


@pytest.mark.parametrize(
    ("source", "leg"), [("pillars", "LF"), ("rubble", "RF"), ("stones", "LH"), ("blocks", "RH"), ("stairs", "LF")]
)
def test_pybullet_sees_the_same_contacts(source: str, leg: str) -> None:
    agreement = check_source(source, leg, "contacts", cells=300, cells_per_place=50)
    assert agreement.cells == 300
    assert max((each.distance for each in agreement.disagreements), default=0.0) <= command.TOLERANCE
    assert len(agreement.disagreements) <= 9
    assert agreement.counts["self"][3] + agreement.counts["terrain"][3] >= 5


def test_a_terrain_two_centimetres_off_would_show(monkeypatch: pytest.MonkeyPatch) -> None:
    """The neighbour's heights: what a slip of an index does."""
    stand = BulletEngine.stand

    def shifted(self: BulletEngine, local_map: LocalMap, tilt: Vector) -> None:
        rolled = LocalMap(np.roll(local_map.heights, 1, axis=1), local_map.resolution, local_map.hip, local_map.yaw)
        stand(self, rolled, tilt)

    monkeypatch.setattr(BulletEngine, "stand", shifted)
    agreement = check_source("pillars", "LF", "contacts", cells=300, cells_per_place=50)
    assert max(each.distance for each in agreement.disagreements) > command.TOLERANCE


def test_full_meshes_differ_by_millimetres() -> None:
    agreement = check_source("pillars", "RH", "meshes", cells=120, cells_per_place=40)
    assert agreement.cells == 120
    assert agreement.counts["self"][3] + agreement.counts["terrain"][3] > 5
    assert len(agreement.disagreements) < 24
    assert max((each.distance for each in agreement.disagreements), default=0.0) < 0.03


def test_the_command_writes_its_figures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "contacts.json"
    arguments = ["contacts", "--families", "pillars", "--cells", "40", "--jobs", "1", "--out", str(out)]
    assert command.main(arguments) == 0
    figures = json.loads(out.read_text())
    assert figures["passed"] and figures["cells"] == 4 * 40
    assert sum(figures["self"].values()) == figures["cells"]
    # Those that hit the robot for the oracle are not asked about the terrain.
    asked = figures["cells"] - figures["self"]["both"] - figures["self"]["oracle_only"]
    assert sum(figures["terrain"].values()) == asked
    assert len(figures["worst"]) == min(figures["disagreements"], command.LISTED)
    assert "pillars" in capsys.readouterr().out


def test_one_disagreement_too_far_fails() -> None:
    def agreement(distance: float) -> Agreement:
        return Agreement(disagreements=[Disagreement("here", "self", True, ["a against b"], distance, {})])

    for distance, passed in ((0.004, True), (0.0075, False), (np.inf, False)):
        part = {("flat", "LF"): agreement(distance)}
        assert command.summary("contacts", part)["passed"] is passed
        assert command.summary("meshes", part)["passed"] is True
    many = Agreement.sum(agreement(distance) for distance in (0.001, 0.003, 0.002))
    assert [each["distance"] for each in many.worst(2)] == [0.003, 0.002]
