"""Explanations: the bodies that meet are those that the reference finds, and the words say what the label says."""

import numpy as np
import pytest

from footsel.errors import InputError
from footsel.footholds import Reason
from footsel.footholds.pose import tilt_rotation
from footsel.oracle import Oracle
from footsel.oracle.brute_force import BruteForceOracle
from footsel.oracle.explanation import LegExplainer, cell_at
from footsel.oracle.verification.places import Place, draw_pose
from footsel.terrain import LocalMap
from footsel.terrain.courses import make_course


@pytest.fixture(scope="module")
def oracle() -> Oracle:
    return Oracle.load("anymal_b")


def place(oracle: Oracle, family: str, leg: str, seed: int) -> Place:
    rng = np.random.default_rng(seed)
    return draw_pose(oracle.robot.layout, family, seed, make_course(family, seed), leg, rng)


@pytest.fixture(scope="module")
def hard_place(oracle: Oracle) -> Place:
    """Among pillars, with cells of every reason but UNKNOWN."""
    for seed in range(50):
        found = place(oracle, "pillars", "RH", seed)
        reason = oracle.label(found.local_map, "RH", *found.tilt).reason
        if min((reason == kind).sum() for kind in Reason if kind != Reason.UNKNOWN) >= 10:
            return found
    pytest.fail("no such place")


@pytest.mark.parametrize(("family", "leg"), [("pillars", "LF"), ("rubble", "RF"), ("stones", "LH"), ("stairs", "RH")])
def test_contacts_are_the_references(oracle: Oracle, family: str, leg: str) -> None:
    explainer, reference = LegExplainer(oracle.robot, leg), BruteForceOracle(oracle.robot, leg)
    rng, compared = np.random.default_rng(0), 0
    for seed in range(4):
        where = place(oracle, family, leg, seed)
        label = oracle.label(where.local_map, leg, *where.tilt)
        contacts = explainer.contacts(label, where.local_map, *where.tilt)
        collides = np.isin(label.reason, [Reason.SELF_COLLISION, Reason.TERRAIN_COLLISION])
        np.testing.assert_array_equal(contacts.touching[..., 0] > 0, collides)
        np.testing.assert_array_equal(contacts.touching[..., 1] > 0, collides)
        for i, j in rng.permutation(np.argwhere(collides))[:25].tolist():
            expected = reference.label_cell(where.local_map, *where.tilt, (i, j), with_margin=False).touching
            explanation = explainer.cell(label, where.local_map, *where.tilt, (i, j))
            assert contacts.between(i, j) == explanation.touching[0]
            assert expected in explanation.touching
            compared += 1
    assert compared > 25


def test_pairs_count_cells(oracle: Oracle, hard_place: Place) -> None:
    label = oracle.label(hard_place.local_map, "RH", *hard_place.tilt)
    contacts = LegExplainer(oracle.robot, "RH").contacts(label, hard_place.local_map, *hard_place.tilt)
    pairs = contacts.pairs()
    assert list(pairs.values()) == sorted(pairs.values(), reverse=True)
    on_terrain = sum(count for (_, other), count in pairs.items() if other == "terrain")
    assert on_terrain == (label.reason == Reason.TERRAIN_COLLISION).sum()
    assert sum(pairs.values()) - on_terrain == (label.reason == Reason.SELF_COLLISION).sum()
    assert all(swing.startswith("RH_") and not other.startswith("RH_") for swing, other in pairs)


def test_every_reason_has_its_words(oracle: Oracle, hard_place: Place) -> None:
    heights = hard_place.local_map.heights.copy()
    heights[0, 0] = np.nan
    ground = LocalMap(heights, 0.02, hard_place.local_map.hip, hard_place.local_map.yaw)
    label = oracle.label(ground, "RH", *hard_place.tilt)
    explainer = LegExplainer(oracle.robot, "RH")
    words = {
        Reason.FEASIBLE: "feasible, cost ",
        Reason.UNKNOWN: "unknown, the map has no elevation here",
        Reason.KINEMATIC_RANGE: "out of kinematic range: ",
        Reason.SELF_COLLISION: "self-collision: RH_",
        Reason.TERRAIN_COLLISION: "terrain collision: RH_",
    }
    for reason, phrase in words.items():
        i, j = np.argwhere(label.reason == reason)[0].tolist()
        explanation = explainer.cell(label, ground, *hard_place.tilt, (i, j))
        text = str(explanation)
        assert text.startswith(f"RH cell {i} {j} at x=") and phrase in text
        assert "nan" not in text.partition(" m: ")[2]
        assert explanation.reason == reason and explanation.cost == label.cost[i, j]
        np.testing.assert_equal(explanation.position, ground.positions()[i, j])
        if reason == Reason.FEASIBLE:
            assert f"{label.kinematic_margin[i, j]:.4f} m of 0.1887 m" in text
            assert f"terrain cost: {label.terrain_cost[i, j]:.3f}" in text
        if reason in {Reason.FEASIBLE, Reason.SELF_COLLISION, Reason.TERRAIN_COLLISION}:
            np.testing.assert_allclose(explanation.joint_angles, label.joint_angles[i, j], atol=1e-12)
            assert f"HAA {label.joint_angles[i, j, 0]:+.3f}" in text
        if reason not in {Reason.SELF_COLLISION, Reason.TERRAIN_COLLISION}:
            assert explanation.touching == ()


def test_a_broken_limit_is_named(oracle: Oracle) -> None:
    """Of every cell out of range the angles that the leg would need break a limit, or no angles put the foot there."""
    robot = oracle.robot
    ground = LocalMap(np.full((40, 40), -0.3, dtype=np.float32), 0.02, np.zeros(3), 0.0)
    roll, pitch = 0.1, -0.15
    label = oracle.label(ground, "LH", roll, pitch)
    explainer = LegExplainer(robot, "LH")
    counts = {"limit": 0, "reach": 0}
    for i, j in np.argwhere(label.reason == Reason.KINEMATIC_RANGE)[::7].tolist():
        explanation = explainer.cell(label, ground, roll, pitch, (i, j))
        if explanation.broken_limits:
            centre = tilt_rotation(roll, pitch) @ robot.kinematics["LH"].forward(explanation.joint_angles)
            contact = [(i - 19.5) * 0.02, (j - 19.5) * 0.02, -0.3 + robot.layout.foot_radius]
            np.testing.assert_allclose(centre, contact, atol=1e-9)
            counts["limit"] += 1
        else:
            assert np.isnan(explanation.joint_angles).any()
            assert f"no pose reaches {explanation.foot_distance:.3f} m" in str(explanation)
            counts["reach"] += 1
    assert min(counts.values()) > 5


def test_a_cell_off_the_map_is_an_error(oracle: Oracle, hard_place: Place) -> None:
    label = oracle.label(hard_place.local_map, "RH", *hard_place.tilt)
    with pytest.raises(InputError, match="cell 40 3 is not on the local map"):
        LegExplainer(oracle.robot, "RH").cell(label, hard_place.local_map, *hard_place.tilt, (40, 3))


def test_the_cell_at_a_place_is_the_one_that_holds_it() -> None:
    ground = LocalMap(np.zeros((40, 40), dtype=np.float32), 0.02, np.array([1.0, -2.0, 0.5]), 0.7)
    positions = ground.positions()
    c, s = np.cos(0.7), np.sin(0.7)
    for i, j in np.random.default_rng(0).integers(40, size=(50, 2)).tolist():
        for along, across in ((0.0, 0.0), (0.0099, -0.0099), (-0.0099, 0.0099)):
            x = positions[i, j, 0] + c * along - s * across
            y = positions[i, j, 1] + s * along + c * across
            assert cell_at(ground, x, y) == (i, j)
    with pytest.raises(InputError, match="is not on the local map"):
        cell_at(ground, 1.0 + 0.42 * c, -2.0 + 0.42 * s)
