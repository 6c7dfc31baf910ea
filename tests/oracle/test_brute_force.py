"""Laws of the reference alone: joint limits, coal, mirror images, balls of free positions, costs worked by hand."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from footsel.footholds.cost import foothold_cost
from footsel.footholds.pose import tilt_rotation
from footsel.footholds.reasons import Reason
from footsel.legs import LEGS
from footsel.oracle.brute_force import BruteForceOracle, brute_force_cell, terrain_solid
from footsel.robot import load_robot
from footsel.robot.robot import stance_configuration
from footsel.terrain import LocalMap

NO_TILT = np.eye(3)


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal_b")


@pytest.fixture(scope="module")
def oracles(robot):
    return {leg: BruteForceOracle(robot, leg) for leg in LEGS}


def local_map(heights, resolution=0.02):
    return LocalMap(np.asarray(heights, dtype=np.float32), resolution, np.zeros(3), 0.0)


def flat(height):
    return local_map(np.full((40, 40), height))


def reasons(oracle, terrain, step, roll=0.0, pitch=0.0):
    """{cell: reason} of every step-th cell."""
    cells = [(i, j) for i in range(0, 40, step) for j in range(0, 40, step)]
    return {cell: oracle.label_cell(terrain, roll, pitch, cell, with_margin=False).reason for cell in cells}


def angles_within(robot, leg, rng, count):
    """Random joint angles within the limits, most of them pushed to the edge of one."""
    low, high = np.array(robot.description.limits[leg]).T
    angles = rng.uniform(low, high, (count, 3))
    for row in angles[count // 4 :]:
        joint, near = rng.integers(3), 10 ** rng.uniform(-8, -2)
        row[joint] = low[joint] + near if rng.random() < 0.5 else high[joint] - near
    return angles


def foot_height_in_leg_plane(robot, leg, angles):
    """Height of the foot's centre over the HFE axis in the leg plane, in the frame that turns with abduction."""
    model, data = robot.model, robot.model.createData()
    configuration = stance_configuration(robot.description, model)
    names = robot.description.joints[leg]
    for name, angle in zip(names, angles, strict=True):
        configuration[model.joints[model.getJointId(name)].idx_q] = angle
    pin.framesForwardKinematics(model, data, configuration)
    haa, hfe = (data.oMi[model.getJointId(name)] for name in names[:2])
    return haa.actInv(data.oMf[robot.foot_frames[leg]].translation)[2] - haa.actInv(hfe.translation)[2]


@pytest.mark.parametrize("leg", LEGS)
def test_every_configuration_in_range_is_found_again(robot, oracles, leg):
    oracle, rng = oracles[leg], np.random.default_rng(LEGS.index(leg))
    found = 0
    for angles in angles_within(robot, leg, rng, 1500):
        if foot_height_in_leg_plane(robot, leg, angles) > -1e-4:
            continue
        answer = oracle.inverse(oracle.forward(angles))
        assert answer is not None, angles
        np.testing.assert_allclose(answer, angles, atol=1e-6)
        found += 1
    assert found > 600


@pytest.mark.parametrize("leg", LEGS)
def test_what_is_found_is_in_range(robot, oracles, leg):
    oracle, rng = oracles[leg], np.random.default_rng(10)
    low, high = np.array(robot.description.limits[leg]).T
    found = 0
    for centre in rng.uniform([-0.4, -0.4, -0.6], [0.4, 0.4, 0.2], (300, 3)):
        angles = oracle.inverse(centre)
        if angles is None:
            continue
        found += 1
        assert np.linalg.norm(oracle.forward(angles) - centre) < 1e-7
        assert (angles >= low - 1e-9).all() and (angles <= high + 1e-9).all()
        assert foot_height_in_leg_plane(robot, leg, angles) < 0
    assert 50 < found < 250


@pytest.mark.parametrize("joint", range(3))
@pytest.mark.parametrize("side", [0, 1])
def test_a_hair_beyond_a_limit_is_out_of_range(robot, oracles, joint, side):
    leg = "LF"
    angles = np.array([-0.1, 0.7, -1.0])
    if joint == 1:
        angles = np.array([0.0, 0.0, -0.5]) if side else np.array([0.0, 0.0, -2.0])
    limit = robot.description.limits[leg][joint][side]
    outwards = 1 if side else -1
    verdicts = []
    for beyond in (-1e-5, 1e-5):
        angles[joint] = limit + outwards * beyond
        verdicts.append(oracles[leg].inverse(oracles[leg].forward(angles)) is not None)
    below = foot_height_in_leg_plane(robot, leg, angles) < 0
    assert verdicts == [below, False]


@pytest.mark.parametrize("leg", ["LF", "RH"])
def test_self_collision_is_that_of_every_pair_put_to_coal(robot, oracles, leg):
    bodies, model, data = robot.bodies[leg], robot.model, robot.model.createData()
    names, rng, hits = robot.description.joints[leg], np.random.default_rng(20), 0
    configuration = stance_configuration(robot.description, model)
    for angles in angles_within(robot, leg, rng, 250):
        for name, angle in zip(names, angles, strict=True):
            configuration[model.joints[model.getJointId(name)].idx_q] = angle
        pin.forwardKinematics(model, data, configuration)

        def touch(swing, obstacle, data=data):
            joint = data.oMi[model.getJointId(names[swing.joint - 1])]
            placed = joint * pin.SE3(swing.rotation, swing.translation)
            return coal.collide(
                swing.shape,
                coal.Transform3s(placed.rotation, placed.translation),
                obstacle.shape,
                coal.Transform3s(obstacle.rotation, obstacle.translation),
                coal.CollisionRequest(),
                coal.CollisionResult(),
            )

        expected = any(touch(bodies.swing[i], bodies.obstacles[j]) for i, j in bodies.pairs)
        assert bool(oracles[leg].self_contact(angles)) == expected
        hits += expected
    assert 10 < hits < 240
    assert not oracles[leg].self_contact(np.array(robot.description.stance[leg]))


def test_terrain_is_a_solid_over_the_cells_and_nowhere_else():
    rng = np.random.default_rng(30)
    heights = rng.uniform(-0.6, -0.3, (40, 40)).astype(np.float32)
    heights[20:, :10] = np.nan
    solid, d = terrain_solid(local_map(heights)), 0.02
    floor = np.nanmin(heights) - 1.0
    vertices = np.where(np.isnan(heights), floor, heights)

    def surface(x, y):
        """Cells are split along the diagonal (i, j) to (i + 1, j + 1)."""
        u, v = x / d + 19.5, y / d + 19.5
        i, j = int(u), int(v)
        a, b = u - i, v - j
        corner = vertices[i + 1, j] if a > b else vertices[i, j + 1]
        near, far = vertices[i, j], vertices[i + 1, j + 1]
        return (
            near + a * (corner - near) + b * (far - corner)
            if a > b
            else near + b * (corner - near) + a * (far - corner)
        )

    counts = [0, 0]
    for x, y, depth in rng.uniform([-0.45, -0.45, -0.7], [0.45, 0.45, 0.3], (1500, 3)):
        on_map = max(abs(x), abs(y)) < 19.5 * d
        ground = surface(x, y) if on_map else -0.5
        z = ground + depth
        if abs(depth) < 1e-3 or abs(z - floor) < 1e-3:
            continue
        point = coal.Transform3s(np.eye(3), np.array([x, y, z]))
        still, request = coal.Transform3s.Identity(), coal.CollisionRequest()
        hit = bool(coal.collide(coal.Sphere(1e-6), point, solid, still, request, coal.CollisionResult()))
        assert hit == (on_map and depth < 0 and z > floor)
        counts[hit] += 1
    assert min(counts) > 200


def test_the_foot_of_a_label_stands_on_its_cell(robot, oracles):
    rng = np.random.default_rng(40)
    terrain = local_map(rng.uniform(-0.5, -0.42, (40, 40)))
    seen = 0
    for _ in range(60):
        leg, (roll, pitch) = str(rng.choice(LEGS)), rng.uniform(-0.2, 0.2, 2)
        i, j = (int(k) for k in rng.integers(8, 32, 2))
        label = oracles[leg].label_cell(terrain, roll, pitch, (i, j), with_margin=False)
        if label.joint_angles is None:
            continue
        centre = tilt_rotation(roll, pitch) @ oracles[leg].forward(label.joint_angles)
        contact = centre - [0, 0, robot.description.foot_radius]
        np.testing.assert_allclose(contact, [(i - 19.5) * 0.02, (j - 19.5) * 0.02, terrain.heights[i, j]], atol=1e-7)
        seen += 1
    assert seen > 20


@pytest.mark.parametrize("left, right", [("LF", "RF"), ("LH", "RH")])
def test_right_legs_mirror_left_ones(oracles, left, right):
    # Terrain that varies along y alone: cells are split along one diagonal, which a mirror would turn into the other.
    profile = -0.4 + 0.1 * np.random.default_rng(50).random(40)
    profile[28:] += 0.25
    heights = np.tile(profile, (40, 1))
    there = reasons(oracles[left], local_map(heights), 3, roll=0.12, pitch=-0.07)
    mirrored = local_map(heights[:, ::-1])
    for (i, j), reason in there.items():
        assert oracles[right].label_cell(mirrored, -0.12, -0.07, (i, 39 - j), with_margin=False).reason == reason
    assert {Reason.FEASIBLE, Reason.KINEMATIC_RANGE, Reason.TERRAIN_COLLISION} <= set(there.values())


def test_flat_ground_within_reach_has_no_collisions_and_out_of_reach_no_footholds(oracles):
    for oracle in oracles.values():
        assert set(reasons(oracle, flat(-0.45), 4).values()) == {Reason.FEASIBLE, Reason.KINEMATIC_RANGE}
        assert set(reasons(oracle, flat(-0.75), 8).values()) == {Reason.KINEMATIC_RANGE}


def test_ground_that_tilts_with_the_base_collides_as_level_ground_does(oracles):
    oracle, rng, hits = oracles["RH"], np.random.default_rng(70), 0
    tilt = tilt_rotation(0.15, -0.2)
    x, y = ((np.stack(np.meshgrid(range(40), range(40), indexing="ij")) - 19.5) * 0.02).astype(float)
    # The points at one height in the base frame: tilt[:, 2] . (x, y, z) = -0.27.
    along = local_map((-0.27 - tilt[0, 2] * x - tilt[1, 2] * y) / tilt[2, 2])
    for angles in rng.uniform([-0.4, -1.3, 0.0], [0.4, 0.5, 2.0], (200, 3)):
        level = oracle.terrain_contact(angles, flat(-0.27), NO_TILT) is not None
        assert (oracle.terrain_contact(angles, along, tilt) is not None) == level
        hits += level
    assert 20 < hits < 180


def test_a_wall_beside_the_shank_collides(oracles):
    oracle, ground = oracles["LF"], np.full((40, 40), -0.45)
    before = reasons(oracle, local_map(ground), 2)
    ground[:10] = -0.2  # behind the foot, where the front knees point
    after = reasons(oracle, local_map(ground), 2)
    changed = {cell: after[cell] for cell in before if after[cell] != before[cell] and cell[0] >= 10}
    assert len(changed) > 5
    assert set(changed.values()) == {Reason.TERRAIN_COLLISION}
    assert {before[cell] for cell in changed} == {Reason.FEASIBLE}
    ground[:10] = np.nan  # unknown terrain collides with nothing
    after = reasons(oracle, local_map(ground), 2)
    assert all(after[cell] == before[cell] for cell in before if cell[0] >= 10)
    assert all(after[cell] == Reason.UNKNOWN for cell in before if cell[0] < 10)


def test_a_foot_under_the_base_or_by_the_hind_thigh_collides_with_the_robot(robot, oracles):
    found = reasons(oracles["LF"], flat(-0.25), 2)
    collided = np.array([cell for cell, reason in found.items() if reason == Reason.SELF_COLLISION])
    feet = robot.layout.hips["LF"][:2] + (collided - 19.5) * 0.02
    under_base = np.abs(feet[:, 1]) < 0.14
    assert under_base.sum() > 5
    # The others are behind the leg, beside the thigh of the left hind leg.
    assert (~under_base).sum() > 3
    assert (feet[~under_base, 0] < 0.25).all() and (feet[~under_base, 1] > 0.2).all()


def test_unknown_comes_first(robot):
    heights = np.full((40, 40), np.nan)
    assert brute_force_cell(robot, local_map(heights), "RH", 0.0, 0.0, (3, 4)).reason == Reason.UNKNOWN
    heights[20, 20] = -0.45
    label = brute_force_cell(robot, local_map(heights), "RH", 0.0, 0.0, (20, 20), with_margin=False)
    assert (label.reason, label.terrain_cost) == (Reason.FEASIBLE, 1.0)
    unknown = brute_force_cell(robot, local_map(heights), "RH", 0.0, 0.0, (20, 21))
    assert (unknown.reason, unknown.cost, unknown.joint_angles) == (Reason.UNKNOWN, 255, None)
    assert np.isnan([unknown.margin, unknown.terrain_cost]).all()


class TestMargin:
    def test_the_ball_is_free_and_its_border_is_not(self, robot, oracles):
        """The margin is the largest: no joint limit is nearer, and every point nearer is free."""
        leg, rng = "LH", np.random.default_rng(60)
        oracle = oracles[leg]
        low, high = np.array(robot.description.limits[leg]).T
        for angles in ([-0.1, -0.4, 0.7], [0.5, -1.3, 1.6]):
            centre = oracle.forward(np.array(angles))
            margin = oracle.margin(centre, np.array(angles))
            assert 0.01 < margin < 0.2
            for offset in rng.normal(size=(60, 3)):
                inside = centre + offset / np.linalg.norm(offset) * margin * 0.98
                configuration = oracle.inverse(inside)
                assert configuration is not None and not oracle.self_contact(configuration)
            faces = rng.uniform(low, high, (4000, 3))
            joint = rng.integers(3, size=len(faces))
            faces[np.arange(len(faces)), joint] = np.where(rng.random(len(faces)) < 0.5, low[joint], high[joint])
            border = [oracle.forward(q) for q in faces if foot_height_in_leg_plane(robot, leg, q) < 0]
            assert margin < np.linalg.norm(np.array(border) - centre, axis=1).min() + 1e-4

    def test_it_is_the_distance_to_the_stretched_knee(self, oracles):
        """Straight below the hip and nearly stretched, the nearest border is the sphere of the KFE limit."""
        oracle = oracles["LF"]
        hfe_to_foot = np.linalg.norm(oracle.forward(np.array([0.0, 0.5, 0.0])))
        angles = np.array([0.0, 0.3, -0.3])
        centre = oracle.forward(angles)
        expected = hfe_to_foot - np.linalg.norm(centre)
        assert oracle.margin(centre, angles) == pytest.approx(expected, abs=2e-3)

    def test_cost_of_a_cell(self, robot):
        terrain = flat(-0.47)
        label = brute_force_cell(robot, terrain, "LF", 0.0, 0.0, (20, 20))
        c_k = 1 - min(label.margin / robot.margin_max("LF"), 1.0)
        assert label.reason == Reason.FEASIBLE
        assert label.cost == pytest.approx(float(foothold_cost(c_k, 0.0)))
        without = brute_force_cell(robot, terrain, "LF", 0.0, 0.0, (20, 20), with_margin=False)
        assert np.isnan([without.cost, without.margin]).all()
