"""The overlap of convex bodies: never another answer than coal's, and an answer wherever bodies do not quite touch."""

import coal
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footsel.oracle.convex import CAPSULE, CENTRE, SIZES, extent, placed, shape_row, support
from footsel.oracle.overlap import CLEAR, COLLIDES, UNDECIDED, overlap, workspace

KINDS = ("box", "cylinder", "capsule", "sphere")


def shape_of(kind: str, rng: np.random.Generator) -> coal.ShapeBase:
    a, b, c = rng.uniform(0.01, 0.15, 3)
    return {
        "box": coal.Box(2 * a, 2 * b, 2 * c),
        "cylinder": coal.Cylinder(a, 2 * b),
        "capsule": coal.Capsule(a, 2 * b),
        "sphere": coal.Sphere(a),
    }[kind]


def random_turn(rng: np.random.Generator) -> np.ndarray:
    """Any rotation, and as often one onto other axes, where faces are parallel."""
    turn = (
        Rotation.random(rng=rng)
        if rng.random() < 0.5
        else Rotation.from_euler("xyz", rng.integers(4, size=3) * 90, True)
    )
    return turn.as_matrix()


def coal_says(first: coal.ShapeBase, second: coal.ShapeBase, turns: np.ndarray, apart: np.ndarray) -> bool:
    here, there = coal.Transform3s(turns[0], np.zeros(3)), coal.Transform3s(turns[1], apart)
    return bool(coal.collide(first, here, second, there, coal.CollisionRequest(), coal.CollisionResult()))


def contradictions(growth: float, count: int = 250) -> tuple[int, int, int]:
    """Wrong answers, missing answers and questions, for pairs a millimetre to a micrometre from touching.

    growth: how much larger the first body is made for the search alone, in [m].
    """
    rng = np.random.default_rng(4)
    wrong = missing = asked = 0
    for number in range(count * len(KINDS)):
        shapes = [shape_of(KINDS[k], rng) for k in (number % 4, rng.integers(4))]
        turns = np.stack([random_turn(rng) for _ in range(2)])
        way = rng.normal(size=3)
        way /= np.linalg.norm(way)
        low, high = 0.0, 1.0
        while high - low > 1e-9:
            middle = (low + high) / 2
            low, high = (middle, high) if coal_says(*shapes, turns, middle * way) else (low, middle)
        gap = rng.choice([-1, 1]) * 10 ** rng.uniform(-6, -3)
        apart = (low + gap) * way
        first, second = (
            placed(shape_row(s)[0], t, p) for s, t, p in zip(shapes, turns, (np.zeros(3), apart), strict=True)
        )
        first[SIZES:CENTRE] += growth * (first[SIZES:CENTRE] > 0)
        answer = overlap(first, second, -way, workspace())
        # A gap along the way is at least a tenth of the distance here, so that it says how near they are.
        if answer == UNDECIDED:
            missing += abs(gap) > 2e-4
        else:
            wrong += (answer == COLLIDES) != coal_says(*shapes, turns, apart)
        asked += 1
    return wrong, missing, asked


def test_never_contradicts_coal_near_touching() -> None:
    wrong, missing, asked = contradictions(0.0)
    assert wrong == 0
    assert missing < 0.01 * asked


@pytest.mark.parametrize("growth", [3e-4, -3e-4])
def test_that_test_sees_a_body_of_the_wrong_size(growth: float) -> None:
    assert contradictions(growth, count=60)[0] > 5


def test_direction_given_back_proves_the_distance() -> None:
    rng = np.random.default_rng(1)
    clear = 0
    for number in range(400):
        rows = [
            placed(shape_row(shape_of(KINDS[(number + k) % 4], rng))[0], random_turn(rng), rng.normal(0, 0.12, 3))
            for k in range(2)
        ]
        direction = rng.normal(size=3)
        if overlap(*rows, direction, workspace()) == CLEAR:
            clear += 1
            nearest = np.dot(direction, support(rows[0], *-direction)) - np.dot(direction, support(rows[1], *direction))
            assert np.linalg.norm(direction) == pytest.approx(1) and nearest > 0
    assert clear > 100


def test_bodies_that_hold_each_other_s_centre_overlap() -> None:
    """The origin is then near the middle of a difference that is symmetric about a point next to it."""
    rng = np.random.default_rng(2)
    for number in range(200):
        first, second = (shape_row(shape_of(KINDS[k], rng))[0] for k in (number % 4, rng.integers(4)))
        apart = rng.uniform(-0.005, 0.005, 3)
        moved = placed(second, random_turn(rng), apart)
        assert overlap(first, moved, -apart, workspace()) == COLLIDES


@pytest.mark.parametrize("kind", KINDS)
def test_support_is_the_furthest_point(kind: str) -> None:
    rng = np.random.default_rng(3)
    row = placed(shape_row(shape_of(kind, rng))[0], random_turn(rng), rng.normal(size=3))
    directions = rng.normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    points = np.array([support(row, *direction) for direction in directions])
    reach = (directions @ points.T).T
    # Of all points of the body that were found, each is the furthest along its own direction.
    assert (reach.argmax(axis=0) == np.arange(300)).mean() > (0.99 if kind in ("capsule", "sphere") else 0.0)
    assert (reach.max(axis=0) <= np.diag(reach) + 1e-12).all()
    for direction, furthest in zip(directions, np.diag(reach), strict=True):
        assert furthest == pytest.approx(direction @ row[CENTRE : CENTRE + 3] + extent(row, *direction))


def test_a_shape_of_no_known_kind_is_in_its_box() -> None:
    ellipsoid = coal.Ellipsoid(0.1, 0.2, 0.3)
    row, exact = shape_row(ellipsoid)
    assert not exact
    np.testing.assert_allclose(row[SIZES:CENTRE], [0.1, 0.2, 0.3])
    row, exact = shape_row(coal.Sphere(0.2))
    assert exact and row[0] == CAPSULE
