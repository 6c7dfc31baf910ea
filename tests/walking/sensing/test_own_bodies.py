"""The capsules hold the robot, and nothing of it stays in an image."""

import coal
import numpy as np
import pinocchio as pin

from footsel.legs import LEGS
from footsel.mapping import D435
from footsel.mapping.capsule import without_bodies
from footsel.walking.sensing.mounts import FRONT
from footsel.walking.sensing.own_bodies import OwnBodies
from footsel.walking.sensing.renderer import true_depth


def surface(shape, rng):
    """Points of a box, cylinder or sphere, its corners and rims above all."""
    if isinstance(shape, coal.Box):
        return rng.choice([-1.0, 1.0], (60, 3)) * shape.halfSide
    angle = rng.uniform(-np.pi, np.pi, 60)
    if isinstance(shape, coal.Cylinder):
        z = rng.choice([-1.0, 1.0], 60) * shape.halfLength
        return np.column_stack([shape.radius * np.cos(angle), shape.radius * np.sin(angle), z])
    assert isinstance(shape, coal.Sphere)
    directions = rng.normal(size=(60, 3))
    return shape.radius * directions / np.linalg.norm(directions, axis=1, keepdims=True)


def test_every_body_is_inside_its_capsule_at_any_joint_angles(robot):
    rng = np.random.default_rng(0)
    joints, names = rng.uniform(-1, 1, 12), [name for leg in LEGS for name in robot.description.joints[leg]]
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = pin.exp3(rng.normal(size=3)), rng.normal(size=3)
    configuration = pin.neutral(robot.model)
    for name, angle in zip(names, joints, strict=True):
        configuration[robot.model.joints[robot.model.getJointId(name)].idx_q] = angle
    data, placements = robot.model.createData(), robot.geometry.createData()
    pin.updateGeometryPlacements(robot.model, data, robot.geometry, placements, configuration)
    capsules = OwnBodies(robot).capsules(base, joints)
    for item, placement, capsule in zip(robot.geometry.geometryObjects, placements.oMg, capsules, strict=True):
        points = surface(item.geometry, rng) @ placement.rotation.T + placement.translation
        points = points @ base[:3, :3].T + base[:3, 3]
        # By a micrometre, for rounding.
        nearer = points + 1e-6 * (0.5 * (capsule.start + capsule.end) - points)
        assert capsule.contains(nearer).all(), item.name


def test_soles_of_the_stance_are_the_nominal_feet(robot, stance):
    base, joints = stance
    feet = np.array([robot.layout.nominal_feet[leg] for leg in LEGS])
    assert np.allclose(OwnBodies(robot).soles(base, joints), feet + base[:3, 3], atol=1e-6)


def test_a_leg_before_the_camera_leaves_no_reading(robot, stance, simulate):
    simulation, (base, joints) = simulate("flat"), stance
    camera = D435(212, 120).camera
    alone = true_depth(simulation.client, camera, base @ FRONT)
    stretched = joints.copy()
    stretched[:3] = -0.1, -1.2, 0.2
    simulation.reset(base, stretched)
    with_leg = camera.readings(true_depth(simulation.client, camera, base @ FRONT))
    simulation.reset(base, joints)
    clear = camera.readings(true_depth(simulation.client, camera, base @ FRONT))
    assert np.allclose(camera.readings(alone), clear)
    in_view = np.abs(with_leg - clear) > 0.02
    assert in_view.sum() > 100
    eye = base @ FRONT
    bodies = [body.seen_from(eye, 0.01) for body in OwnBodies(robot).capsules(base, stretched)]
    left = without_bodies(with_leg, camera, bodies)
    assert np.abs(left - clear)[left > 0].max() < 1e-3
    # No more is lost than the leg and what lies close to it.
    assert (left == 0).sum() < 3 * in_view.sum() + (clear == 0).sum()
