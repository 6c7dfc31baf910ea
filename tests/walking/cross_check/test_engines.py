"""Two engines on one leg: bodies in the same places, the same contacts, and a fault in either would show."""

import numpy as np
import pytest

from footsel.footholds.pose import tilt_rotation
from footsel.legs import LEGS
from footsel.oracle import Oracle
from footsel.terrain import LocalMap
from footsel.walking.cross_check.bullet_engine import BulletEngine
from footsel.walking.cross_check.coal_engine import CoalEngine
from footsel.walking.cross_check.engine import SHIFTS, Engine
from footsel.walking.cross_check.full_meshes import leg_meshes

ROBOT = Oracle.load().robot
STANCE = np.array(ROBOT.description.stance["LF"])


def level(height: float) -> LocalMap:
    return LocalMap(np.full((40, 40), height, dtype=np.float32), 0.02, np.zeros(3), 0.0)


def engines(leg: str = "LF") -> dict[str, Engine]:
    return {
        "coal": CoalEngine(ROBOT, leg),
        "pybullet": BulletEngine(ROBOT, leg),
        "meshes": CoalEngine(ROBOT, leg, leg_meshes(ROBOT, leg)),
    }


@pytest.mark.parametrize("leg", LEGS)
def test_bodies_are_where_pinocchio_puts_them(leg: str) -> None:
    bullet, coal_engine, rng = BulletEngine(ROBOT, leg), CoalEngine(ROBOT, leg), np.random.default_rng(0)
    low, high = np.array(ROBOT.description.limits[leg]).T
    for _ in range(20):
        tilt, shift = tilt_rotation(*rng.uniform(-0.3, 0.3, 2)), rng.uniform(-0.1, 0.1, 3)
        angles = rng.uniform(low, high)
        for engine in (bullet, coal_engine):
            engine.stand(level(-0.5), tilt)
        placed = coal_engine._trimmed(angles, shift)
        bullet._pose(angles, shift)
        for body, at in placed:
            np.testing.assert_allclose(bullet._centre(bullet._trimmed[body.name]), at.getTranslation(), atol=1e-6)


@pytest.mark.parametrize("name", ["coal", "pybullet", "meshes"])
def test_nothing_touches_at_the_nominal_stance(name: str) -> None:
    engine = engines()[name]
    engine.stand(level(-0.55), np.eye(3))
    assert engine.self_contacts(STANCE) == []
    assert engine.terrain_contacts(STANCE) == []


@pytest.mark.parametrize("name", ["coal", "pybullet", "meshes"])
def test_a_leg_turned_inwards_hits_the_base_and_one_stretched_down_the_ground(name: str) -> None:
    engine = engines()[name]
    engine.stand(level(-0.3), np.eye(3))
    inwards = np.array([-1.1, 0.5, -1.5])
    assert any("base" in other for _, other in engine.self_contacts(inwards))
    assert any("ADAPTER" in body for body in engine.terrain_contacts(STANCE))


@pytest.mark.parametrize("name", ["coal", "pybullet", "meshes"])
def test_a_leg_under_the_ground_touches_it(name: str) -> None:
    """Though it cuts no triangle: terrain is a solid."""
    engine = engines()[name]
    engine.stand(level(0.5), np.eye(3))
    bodies = {"coal": 5, "pybullet": 5, "meshes": 3}
    assert len(engine.terrain_contacts(STANCE)) == bodies[name]


@pytest.mark.parametrize(
    ("name", "gap"), [("coal", 0.0007), ("coal", 0.0027), ("coal", 0.0072), ("pybullet", 0.0027), ("pybullet", 0.0072)]
)
def test_the_distance_is_the_shift_that_changes_the_answer(name: str, gap: float) -> None:
    """Ground a little below the lowest point of the trimmed leg, then as much above it."""
    engine = engines()[name]
    lowest = _lowest(CoalEngine(ROBOT, "LF"))
    for height, touches in ((lowest - gap, False), (lowest + gap, True)):
        engine.stand(level(height), np.eye(3))
        assert engine.touches("terrain", STANCE) == touches
        found = engine.distance_to_other_answer("terrain", STANCE)
        # PyBullet keeps a margin of a millimetre around its shapes.
        near = [shift for shift in SHIFTS if abs(shift - gap) < 1.2e-3 + 0.5 * gap]
        assert found in near


def test_it_is_far_from_touching_in_the_air() -> None:
    engine = CoalEngine(ROBOT, "LF")
    engine.stand(level(-0.9), np.eye(3))
    assert engine.distance_to_other_answer("terrain", STANCE) == np.inf
    distance, (body, other) = engine.clearance("terrain", STANCE)
    assert distance == pytest.approx(_lowest(engine) + 0.9, abs=1e-4)
    assert (body, other) == ("LF_ADAPTER_0", "terrain")


def test_meshes_are_cut_where_the_primitives_are() -> None:
    whole = {body.name: body for body in leg_meshes(ROBOT, "RH").swing}
    for body in leg_meshes(ROBOT, "RH").trimmed:
        vertices = np.array(body.shape.vertices())
        if "ADAPTER" not in body.name:
            continue
        in_knee = vertices @ body.rotation.T + body.translation
        centre = ROBOT.model.frames[ROBOT.foot_frames["RH"]].placement.translation
        # The shank's axis is the joint frame's z axis here; the foot is at its lower end.
        assert in_knee[:, 2].min() == pytest.approx(centre[2] + ROBOT.description.foot_trim, abs=1e-6)
        before = np.array(whole[body.name].shape.vertices())
        assert vertices[:, 2].max() == pytest.approx(before[:, 2].max())
        assert before[:, 2].min() < vertices[:, 2].min() - 0.05


def _lowest(engine: CoalEngine) -> float:
    """Height of the lowest point of the trimmed leg at the stance, by bisection, in [m]."""
    low, high = -0.8, -0.2
    while high - low > 1e-6:
        middle = (low + high) / 2
        engine.stand(level(middle), np.eye(3))
        low, high = (low, middle) if engine.touches("terrain", STANCE) else (middle, high)
    engine.stand(level(-0.9), np.eye(3))
    return low
