"""The fast oracle equals the brute-force reference, and a fault in any constraint would show."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from footsel.footholds import Reason
from footsel.footholds.pose import tilt_rotation
from footsel.legs import LEGS
from footsel.oracle import Oracle, labeler, terrain_collision, verification
from footsel.oracle.brute_force import BruteForceOracle
from footsel.oracle.labeler import LegOracle
from footsel.oracle.self_collision import ExactSelfCollision
from footsel.oracle.terrain_collision import TerrainCollision
from footsel.oracle.verification import Comparison, compare, compare_source, draw_local_map
from footsel.terrain import LocalMap
from footsel.terrain.courses import FAMILIES, make_course

SHARED_MAPS = sorted((Path(__file__).resolve().parents[3] / "shared" / "maps").glob("*.npz"))
SOURCES = (*FAMILIES, *map(str, SHARED_MAPS))
#: Largest error of the margin that its voxels may cause. [m]
MARGIN_TOLERANCE = 0.003


@cache
def reference(leg: str) -> BruteForceOracle:
    return BruteForceOracle(Oracle.load().robot, leg)


def check(comparison: Comparison) -> None:
    assert not comparison.differing, "\n".join(comparison.differing[:10])
    assert comparison.terrain_cost_error < 1e-6
    assert max(comparison.margin_errors, default=0.0) < MARGIN_TOLERANCE


def test_every_kind_of_terrain_is_there() -> None:
    if not SHARED_MAPS:
        pytest.skip("the maps made by others (../shared/maps) are not here; only built-in courses are compared")
    assert len(SHARED_MAPS) >= 10


@pytest.mark.parametrize("source", SOURCES, ids=lambda source: Path(source).stem)
def test_equals_the_reference_on_a_sample(source: str) -> None:
    leg = LEGS[SOURCES.index(source) % 4]
    check(compare_source(source, leg, maps=2, cells_per_map=60, margins=0))


@pytest.mark.parametrize("leg", LEGS)
def test_margin_equals_the_reference_on_a_sample(leg: str) -> None:
    comparison = compare_source("rough", leg, maps=1, cells_per_map=40, margins=2)
    check(comparison)
    assert len(comparison.margin_errors) == 2


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
    monkeypatch.setattr(ExactSelfCollision, "collides", lambda *_: False)


def _height_field_upside_down(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        terrain_collision.Terrain,
        "field",
        property(
            lambda self: terrain_collision.coal.HeightFieldOBBRSS(
                0.78, 0.78, np.asfortranarray(np.nan_to_num(self.heights, nan=self.floor).T), self.floor
            )
        ),
    )


def _undecided_is_clear(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(TerrainCollision, "_ask", lambda *_, **__: [])


def _no_diagonal_neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    def faulty(heights: np.ndarray, resolution: float) -> np.ndarray:
        padded = np.pad(heights, 1, constant_values=np.nan)
        around = np.stack([padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]])
        slope = np.nanmean(np.abs(heights - around), axis=0) / resolution
        return np.where(np.isnan(heights), np.nan, 1 - np.exp(-0.5 * (slope / 0.7) ** 2))

    monkeypatch.setattr(labeler, "terrain_costs", faulty)


FAULTS = {
    "kinematic range: foot radius forgotten": _without_foot_radius,
    "kinematic range: roll of the wrong sign": _tilt_the_wrong_way,
    "self-collision: undecided taken for free": _undecided_is_free,
    "terrain collision: height field upside down": _height_field_upside_down,
    "terrain collision: undecided taken for clear": _undecided_is_clear,
    "terrain cost: diagonal neighbours forgotten": _no_diagonal_neighbours,
}


@cache
def hard_samples() -> list[tuple[LocalMap, float, float, np.ndarray]]:
    """Maps of obstacles, and on each the cells near where the constraints decide."""
    oracle = Oracle.load()
    rng = np.random.default_rng(5)
    samples = []
    for source in ("pillars", "stones", "blocks"):
        local_map, roll, pitch = draw_local_map(oracle, make_course(source, 3), "LF", rng)
        reason = oracle.label(local_map, "LF", roll, pitch).reason
        picked = [np.argwhere(reason == kind) for kind in Reason]
        cells = np.concatenate([rng.permutation(kind)[:120] for kind in picked])
        samples.append((local_map, roll, pitch, cells))
    return samples


@pytest.mark.parametrize("fault", FAULTS)
def test_planted_fault_is_caught(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    plant: Callable[[pytest.MonkeyPatch], None] = FAULTS[fault]
    samples = hard_samples()
    plant(monkeypatch)
    oracle = Oracle(Oracle.load().robot)
    comparison = Comparison()
    for local_map, roll, pitch, cells in samples:
        label = oracle.label(local_map, "LF", roll, pitch)
        compare(label, reference("LF"), local_map, (roll, pitch), cells, comparison)
        if comparison.differing or comparison.terrain_cost_error > 1e-6:
            return
    pytest.fail(f"{fault} went unnoticed over {comparison.cells} cells")


def test_planted_margin_fault_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """A field that is off by two voxels."""
    robot = Oracle.load().robot
    tables = labeler.load_tables(robot, "LF")
    faulty = replace(tables, margin=replace(tables.margin, origin=tables.margin.origin + 0.01))
    monkeypatch.setattr(labeler, "load_tables", lambda *_: faulty)
    comparison = compare_source("flat", "LF", maps=1, cells_per_map=60, margins=2, oracle=Oracle(robot))
    assert max(comparison.margin_errors) > MARGIN_TOLERANCE


def test_verification_command_writes_its_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "verify.json"
    arguments = ["--maps-per-leg", "1", "--cells", "4", "--margins", "0", "--jobs", "1", "--out", str(out)]
    monkeypatch.setattr("sys.argv", ["verification", *arguments])
    assert verification.main() == 0
    figures = json.loads(out.read_text())
    assert figures["cells"] == sum(figures["cells_by_reason"].values()) == len(FAMILIES) * 4 * 4
    assert figures["differing_reasons"] == 0 and figures["margins"] == 0


def test_verification_command_fails_if_a_reason_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    arguments = ["--maps-per-leg", "1", "--cells", "40", "--margins", "0", "--jobs", "1"]
    monkeypatch.setattr("sys.argv", ["verification", *arguments])
    monkeypatch.setattr(verification, "FAMILIES", {"pillars": FAMILIES["pillars"]})
    _tilt_the_wrong_way(monkeypatch)
    assert verification.main() == 1
