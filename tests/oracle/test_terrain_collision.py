"""Bodies against terrain: the compiled search and coal's height field say the same, near touching above all."""

from dataclasses import replace

import coal
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footsel.footholds.pose import tilt_rotation
from footsel.oracle import Oracle
from footsel.oracle.convex import ROW, placed, shape_row
from footsel.oracle.overlap import COLLIDES, UNDECIDED, workspace
from footsel.oracle.swing_bodies import SwingBodies
from footsel.oracle.terrain_collision import Terrain, TerrainCollision, body_against_terrain, quad_maxima
from footsel.robot.collision_geometry import Body
from footsel.robot.robot import load_robot
from footsel.terrain.courses import make_course

SHAPES = (coal.Box(0.08, 0.04, 0.25), coal.Cylinder(0.06, 0.12), coal.Cylinder(0.015, 0.25), coal.Capsule(0.02, 0.2))


def search_says(body: np.ndarray, heights: np.ndarray, resolution: float) -> int:
    directions = np.tile([0.0, 0.0, 1.0], (2, 1))
    return body_against_terrain(body, heights, quad_maxima(heights), resolution, np.empty(ROW), directions, workspace())


def coal_says(terrain: Terrain, shape: coal.ShapeBase, turn: np.ndarray, point: np.ndarray) -> bool:
    here, there = coal.Transform3s.Identity(), coal.Transform3s(turn, point)
    return bool(coal.collide(terrain.field, here, shape, there, coal.CollisionRequest(), coal.CollisionResult()))


def rugged(rng: np.random.Generator) -> Terrain:
    """Walls, holes and bumps on 14x14 cells; some are unknown."""
    heights = rng.normal(0, 0.004, (14, 14)) + 0.12 * (rng.random((14, 14)) < 0.12)
    heights[rng.random((14, 14)) < 0.04] = np.nan
    return Terrain(heights, 0.02)


def contradictions(change: str = "", count: int = 500) -> tuple[int, int]:
    """Wrong and missing answers to questions up to a millimetre from touching; change: a fault in the search."""
    rng = np.random.default_rng(7)
    wrong = missing = 0
    for number in range(count):
        terrain, shape = rugged(rng), SHAPES[number % len(SHAPES)]
        turn = Rotation.random(rng=rng).as_matrix() if number % 3 else np.eye(3)
        foot, way = rng.uniform(-0.15, 0.15, 3) * [1, 1, 0], np.append(rng.normal(0, 0.5, 2), 1.0)
        low, high = 0.0, 0.6
        if not coal_says(terrain, shape, turn, foot):
            continue
        while high - low > 1e-9:
            middle = (low + high) / 2
            low, high = (middle, high) if coal_says(terrain, shape, turn, foot + middle * way) else (low, middle)
        gap = rng.choice([-1, 1]) * 10 ** rng.uniform(-6, -3)
        point, heights = foot + (low + gap) * way, terrain.vertices
        body = placed(shape_row(shape)[0], turn, point)
        if change == "other diagonal":
            # In a mirror the quads are split the other way.
            mirror = np.diag([1.0, -1.0, 1.0])
            body = placed(shape_row(shape)[0], mirror @ turn @ mirror, mirror @ point)
            heights = np.ascontiguousarray(heights[:, ::-1])
        elif change == "lower":
            heights = heights - 3e-4
        answer = search_says(body, heights, terrain.resolution)
        if answer == UNDECIDED:
            missing += abs(gap) > 3e-4
        else:
            wrong += (answer == COLLIDES) != coal_says(terrain, shape, turn, point)
    return wrong, missing


def test_never_contradicts_coal_near_touching() -> None:
    wrong, missing = contradictions()
    assert wrong == 0
    assert missing <= 3


@pytest.mark.parametrize("change", ["other diagonal", "lower"])
def test_that_test_sees_faults(change: str) -> None:
    assert contradictions(change, count=150)[0] > 5


@pytest.fixture(scope="module")
def oracle() -> Oracle:
    return Oracle.load("anymal_b")


def course_angles(oracle: Oracle, family: str, roll: float, pitch: float) -> tuple[Terrain, np.ndarray, np.ndarray]:
    """Terrain, tilt and joint angles (k, 3) of a leg on cells of a course that are in kinematic range."""
    elevation = make_course(family, 5).elevation[100:140, 100:140].astype(np.float64)
    terrain = Terrain(elevation - np.median(elevation) - 0.45, 0.02)
    centres = (np.arange(40) - 19.5) * 0.02
    contacts = np.stack([*np.meshgrid(centres, centres, indexing="ij"), terrain.heights], axis=-1).reshape(-1, 3)
    tilt = tilt_rotation(roll, pitch)
    angles, reachable = oracle.robot.kinematics["LF"].inverse((contacts + np.array([0, 0, 0.031])) @ tilt)
    return terrain, tilt, angles[reachable][::5]


COURSES = (("pillars", 0.1, 0.0), ("blocks", 0.0, -0.2), ("rubble", -0.1, 0.2), ("stones", 0.0, 0.0))


def test_legs_collide_as_coal_alone_says(oracle: Oracle) -> None:
    robot = oracle.robot
    collision = TerrainCollision(SwingBodies.of(robot, "LF", robot.bodies["LF"].trimmed))
    verdicts: list[bool] = []
    for course in COURSES:
        terrain, tilt, angles = course_angles(oracle, *course)
        fast = collision.check(terrain, tilt, angles)
        assert fast.tolist() == [bool(collision.touching(terrain, tilt, q)) for q in angles]
        verdicts += fast.tolist()
    assert 0.1 < np.mean(verdicts) < 0.9


def test_order_of_the_cells_changes_nothing(oracle: Oracle) -> None:
    """Directions are carried from one cell to the next, to begin with them."""
    robot = oracle.robot
    collision = TerrainCollision(SwingBodies.of(robot, "LF", robot.bodies["LF"].trimmed))
    terrain, tilt, angles = course_angles(oracle, "stones", 0.1, -0.1)
    forward, backward = collision.check(terrain, tilt, angles), collision.check(terrain, tilt, angles[::-1])
    np.testing.assert_array_equal(forward, backward[::-1])


def test_a_body_known_by_its_box_alone_is_left_to_coal(oracle: Oracle) -> None:
    bodies: list[Body] = [
        replace(body, shape=coal.Ellipsoid(0.05, 0.06, 0.1)) if "THIGH_1" in body.name else body
        for body in load_robot().bodies["LF"].trimmed
    ]
    collision = TerrainCollision(SwingBodies.of(oracle.robot, "LF", bodies))
    terrain, tilt, angles = course_angles(oracle, "pillars", 0.1, 0.0)
    fast = collision.check(terrain, tilt, angles)
    assert fast.tolist() == [bool(collision.touching(terrain, tilt, q)) for q in angles]
