"""What is looked up equals what would be asked, and the cache can be lost or damaged at any time."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from footsel.files import cache_folder
from footsel.legs import LEGS
from footsel.oracle import Oracle, tables
from footsel.oracle.kinematic_margin import MarginField
from footsel.oracle.self_collision import COLLIDES, FREE, UNDECIDED, ExactSelfCollision, SelfCollisionTable
from footsel.oracle.tables import load_tables
from footsel.robot import load_robot


def reachable_configurations(leg: str, count: int, seed: int) -> np.ndarray:
    limits = load_robot().kinematics[leg].limits
    return np.random.default_rng(seed).uniform(limits[:, 0], limits[:, 1], (count, 3))


@pytest.mark.parametrize("leg", LEGS)
def test_certain_answers_are_coal_s(leg: str) -> None:
    """Right legs through the mirrored table, as the oracle asks it."""
    robot = load_robot()
    angles = reachable_configurations(leg, 4000, seed=1)
    table = load_tables(robot, robot.table_leg(leg)).self_collision
    signs = np.array([1.0 if robot.table_leg(leg) == leg else -1.0, 1.0, 1.0])
    answers = table.look_up(angles * signs)
    exact = ExactSelfCollision(robot, leg)
    certain = np.flatnonzero(answers != UNDECIDED)
    assert len(certain) > 3000 and {FREE, COLLIDES} <= set(answers.tolist())
    for row in certain:
        assert exact.collides(angles[row]) == (answers[row] == COLLIDES)


def test_touching_names_the_bodies() -> None:
    robot = load_robot()
    exact = ExactSelfCollision(robot, "LF")
    angles = next(q for q in reachable_configurations("LF", 500, seed=2) if exact.collides(q))
    for swing, obstacle in exact.touching(angles):
        assert swing.startswith("LF_") and not obstacle.startswith("LF_")
    assert not exact.touching(robot.description.stance["LF"])


@pytest.mark.parametrize("leg", ["LF", "LH"])
def test_margin_is_a_distance(leg: str) -> None:
    """It changes by no more than the foot moves, is 0 out of range and positive well inside."""
    robot = load_robot()
    field = load_tables(robot, leg).margin
    rng = np.random.default_rng(0)
    near = rng.uniform([-0.5, -0.4, -0.6], [0.5, 0.4, -0.1], (20000, 3))
    step = rng.normal(0, 0.02, near.shape)
    change = np.abs(field.look_up(near + step) - field.look_up(near))
    assert (change <= np.linalg.norm(step, axis=1) + 0.003).all()
    reachable = robot.kinematics[leg].inverse(near)[1]
    assert field.look_up(near)[~reachable].max() < 0.004
    nominal = robot.layout.nominal_feet[leg] - robot.layout.hips[leg] + [0, 0, robot.layout.foot_radius]
    assert 0.03 < field.look_up(nominal[None])[0] < field.largest


def test_margin_max_of_the_description_is_the_table_s() -> None:
    robot = load_robot()
    for leg in LEGS:
        largest = load_tables(robot, robot.table_leg(leg)).margin.largest
        assert robot.margin_max(leg) == pytest.approx(largest, abs=5e-4)


@pytest.fixture
def tiny_tables(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[list[str]]:
    """An empty cache folder, and tables that cost nothing to build; yields what was built."""
    built: list[str] = []

    def build_table(_: object, leg: str) -> SelfCollisionTable:
        built.append(leg)
        return SelfCollisionTable(np.zeros((2, 2, 2), np.uint8), np.zeros(3), np.ones(3))

    monkeypatch.setenv("FOOTSEL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(tables.SelfCollisionTable, "build", build_table)
    field = MarginField(np.full((2, 2, 2), 0.1, np.float32), np.zeros(3))
    monkeypatch.setattr(tables.MarginField, "build", lambda *_: field)
    load_tables.cache_clear()
    yield built
    load_tables.cache_clear()


def test_tables_are_built_once_and_again_if_the_cache_is_damaged(tiny_tables: list[str]) -> None:
    robot = load_robot()
    first = load_tables(robot, "LF")
    load_tables.cache_clear()
    second = load_tables(robot, "LF")
    assert tiny_tables == ["LF"]
    np.testing.assert_array_equal(first.margin.distance, second.margin.distance)
    (path,) = cache_folder().iterdir()
    for damage in (b"", path.read_bytes()[:100], b"not an archive"):
        path.write_bytes(damage)
        load_tables.cache_clear()
        load_tables(robot, "LF")
    assert tiny_tables == ["LF"] * 4
    assert list(cache_folder().iterdir()) == [path]


def test_oracles_of_one_robot_are_shared() -> None:
    assert Oracle.load("anymal_b") is Oracle.load("anymal_b")
