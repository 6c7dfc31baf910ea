"""The fast oracle equals the brute-force reference, and a fault in any constraint would show."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from footsel.footholds import Reason
from footsel.footholds.pose import tilt_rotation
from footsel.legs import LEGS
from footsel.oracle import Oracle, labeler
from footsel.oracle.brute_force import BruteForceOracle
from footsel.oracle.labeler import LegOracle
from footsel.oracle.self_collision import ExactSelfCollision
from footsel.oracle.swing_bodies import SwingBodies
from footsel.oracle.terrain_collision import Terrain, TerrainCollision
from footsel.oracle.verification.comparison import Comparison, compare_cells, compare_source
from footsel.oracle.verification.places import Place, draw_pose
from footsel.robot.collision_geometry import Body, LegBodies
from footsel.robot.robot import Robot
from footsel.terrain.courses import FAMILIES, make_course

SHARED_MAPS = sorted((Path(__file__).resolve().parents[3] / "shared" / "maps").glob("*.npz"))
SOURCES = (*FAMILIES, *map(str, SHARED_MAPS))
#: What is compared at every run of the tests; `make verify` compares twenty times as much.
CELLS = 10_000
#: Largest error of the margin that its voxels may cause. [m]
MARGIN_TOLERANCE = 0.003


def check(comparison: Comparison) -> None:
    assert not comparison.differing, "\n".join(comparison.differing[:10])
    assert comparison.terrain_cost_error < 1e-6
    assert comparison.margin_errors.max(initial=0.0) < MARGIN_TOLERANCE


def test_every_kind_of_terrain_is_there() -> None:
    if not SHARED_MAPS:
        pytest.skip("the maps made by others (../shared/maps) are not here; only built-in courses are compared")
    assert len(SHARED_MAPS) >= 10


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: Path(source).stem)
def test_equals_the_reference_on_a_sample(source: str) -> None:
    leg, cells = LEGS[SOURCES.index(source) % 4], -(-CELLS // len(SOURCES))
    comparison = compare_source(source, leg, cells, cells_per_place=80, margins=0, seed=1)
    check(comparison)
    assert comparison.known_cells == cells


@pytest.mark.parametrize("leg", LEGS)
def test_margin_equals_the_reference_on_a_sample(leg: str) -> None:
    comparison = compare_source("rough", leg, cells=160, cells_per_place=40, margins=3)
    check(comparison)
    assert len(comparison.margins) == 3


# Planted faults: each breaks one constraint of the fast path, and the comparison must see it.


def _without_foot_radius(monkeypatch: pytest.MonkeyPatch) -> None:
    initialise = LegOracle.__init__

    def faulty(self: LegOracle, *arguments: object) -> None:
        initialise(self, *arguments)  # type: ignore[arg-type]
        self._foot = np.zeros(3)

    monkeypatch.setattr(LegOracle, "__init__", faulty)


def _tilt_the_wrong_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(labeler, "tilt_rotation", lambda roll, pitch: tilt_rotation(-roll, pitch))


def _undecided_is_free(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ExactSelfCollision, "check", lambda _, angles: np.zeros(len(angles), dtype=np.bool_))


def _table_of_the_other_side(monkeypatch: pytest.MonkeyPatch) -> None:
    initialise = LegOracle.__init__

    def faulty(self: LegOracle, *arguments: object) -> None:
        initialise(self, *arguments)  # type: ignore[arg-type]
        self._angle_signs = self._angle_signs * [-1, 1, 1]

    monkeypatch.setattr(LegOracle, "__init__", faulty)


def _heights_upside_down(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Terrain, "vertices", property(lambda self: self.heights[:, ::-1].copy()))


def _with_bodies(choose: Callable[[LegBodies], tuple[Body, ...]]) -> Callable[[pytest.MonkeyPatch], None]:
    """Other bodies than the trimmed ones against the terrain."""
    initialise = LegOracle.__init__

    def faulty(self: LegOracle, robot: Robot, leg: str) -> None:
        initialise(self, robot, leg)
        self._terrain_collision = TerrainCollision(SwingBodies.of(robot, leg, choose(robot.bodies[leg])))

    return lambda monkeypatch: monkeypatch.setattr(LegOracle, "__init__", faulty)


def _cost_of_the_next_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    right = labeler.terrain_costs
    monkeypatch.setattr(labeler, "terrain_costs", lambda *arguments: np.roll(right(*arguments), 1, axis=0))


FAULTS = {
    "kinematic range: foot radius forgotten": _without_foot_radius,
    "kinematic range: roll of the wrong sign": _tilt_the_wrong_way,
    "self-collision: undecided taken for free": _undecided_is_free,
    "self-collision: the other side's table": _table_of_the_other_side,
    "terrain collision: heights upside down": _heights_upside_down,
    "terrain collision: knee forgotten": _with_bodies(
        lambda bodies: tuple(b for b in bodies.trimmed if "THIGH_1" not in b.name)
    ),
    "terrain collision: shank not trimmed": _with_bodies(lambda bodies: bodies.swing),
    "terrain cost: that of the cell behind": _cost_of_the_next_cell,
}


@cache
def hard_samples() -> list[tuple[Place, np.ndarray]]:
    """Places among obstacles, and at each the cells near where the constraints decide."""
    oracle = Oracle.load()
    rng = np.random.default_rng(5)
    samples = []
    for source in ("pillars", "stones", "blocks"):
        place = draw_pose(oracle.robot.layout, source, 3, make_course(source, 3), "LF", rng)
        reason = oracle.label(place.local_map, "LF", *place.tilt).reason
        samples.append((place, np.concatenate([rng.permutation(np.argwhere(reason == k))[:120] for k in Reason])))
    return samples


@pytest.mark.parametrize("fault", FAULTS)
def test_planted_fault_is_caught(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plant: Callable[[pytest.MonkeyPatch], None] = FAULTS[fault]
    samples = hard_samples()
    plant(monkeypatch)
    oracle = Oracle(Oracle.load().robot)
    reference = BruteForceOracle(oracle.robot, "LF")
    comparison = Comparison()
    for place, cells in samples:
        label = oracle.label(place.local_map, "LF", *place.tilt)
        compare_cells(label, reference, place, cells, comparison)
        if comparison.differing or comparison.terrain_cost_error > 1e-6:
            return
    pytest.fail(f"{fault} went unnoticed over {comparison.cells} cells")


def test_planted_margin_fault_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """A field that is off by two voxels."""
    robot = Oracle.load().robot
    tables = labeler.load_tables(robot, "LF")
    faulty = replace(tables, margin=replace(tables.margin, origin=tables.margin.origin + 0.01))
    monkeypatch.setattr(labeler, "load_tables", lambda *_: faulty)
    comparison = compare_source("flat", "LF", cells=60, cells_per_place=60, margins=2, oracle=Oracle(robot))
    assert comparison.margin_errors.max() > MARGIN_TOLERANCE
