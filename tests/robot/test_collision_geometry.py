"""What is trimmed, and which pairs are checked."""

import dataclasses

import coal
import numpy as np
import pinocchio as pin
import pytest

from footsel.errors import InputError
from footsel.legs import LEGS
from footsel.robot import load_robot
from footsel.robot.collision_geometry import leg_bodies, stance_configuration


@pytest.fixture(scope="module")
def robot():
    return load_robot("anymal_b")


def foot_in_knee(robot, leg):
    """(3,) foot centre in the frame of the KFE joint."""
    return robot.model.frames[robot.foot_frames[leg]].placement.translation


def bodies_trimmed_at(robot, radius):
    description = dataclasses.replace(robot.description, foot_trim=radius)
    feet = {leg: foot_in_knee(robot, leg) for leg in LEGS}
    return leg_bodies(description, robot.model, robot.geometry, feet)


def distance_to_foot(body, foot):
    point = coal.Transform3s(np.eye(3), foot)
    placed = coal.Transform3s(body.rotation, body.translation)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return coal.distance(body.shape, placed, coal.Sphere(1e-9), point, request, result)


@pytest.mark.parametrize("leg", LEGS)
def test_nothing_is_left_within_the_trim_radius(robot, leg):
    bodies, foot, radius = robot.bodies[leg], foot_in_knee(robot, leg), robot.description.foot_trim
    at_knee = [body for body in bodies.trimmed if body.joint == 3]
    nearest = [distance_to_foot(body, foot) for body in at_knee]
    assert min(nearest) == pytest.approx(radius, abs=1e-6)
    assert robot.description.foot_geometry[leg] in [body.name for body in bodies.swing]
    assert robot.description.foot_geometry[leg] not in [body.name for body in bodies.trimmed]


@pytest.mark.parametrize("radius", [0.04, 0.05, 0.12])
def test_the_shank_is_cut_across_its_axis_and_keeps_its_other_end(robot, radius):
    """Axial extents in the frame of the cylinder as it is in the URDF."""
    bodies = bodies_trimmed_at(robot, radius)["LH"]
    whole = next(body for body in bodies.swing if body.name == "LH_ADAPTER_0")
    cut = next(body for body in bodies.trimmed if body.name == "LH_ADAPTER_0")
    axis = whole.rotation[:, 2]
    shift = axis @ (cut.translation - whole.translation)
    foot = axis @ (foot_in_knee(robot, "LH") - whole.translation)
    ends = np.array([-1.0, 1.0])
    whole_ends, cut_ends = ends * whole.shape.halfLength, shift + ends * cut.shape.halfLength
    np.testing.assert_allclose(cut.rotation, whole.rotation)
    np.testing.assert_allclose(whole.translation + shift * axis, cut.translation, atol=1e-12)
    assert cut.shape.radius == whole.shape.radius
    near = int(np.argmin(np.abs(whole_ends - foot)))
    assert cut_ends[1 - near] == pytest.approx(whole_ends[1 - near])
    assert abs(cut_ends[near] - foot) == pytest.approx(radius)


def test_thigh_and_upper_shank_stay_whole(robot):
    for bodies in robot.bodies.values():
        trimmed = {body.name: body for body in bodies.trimmed}
        for body in bodies.swing:
            if not body.name.endswith(("FOOT_0", "ADAPTER_0")):
                assert trimmed[body.name] is body


def test_a_box_that_reaches_the_foot_is_refused(robot):
    with pytest.raises(InputError, match=r"SHANK_0 \(Box\) reaches within 0.28 m"):
        bodies_trimmed_at(robot, 0.28)


@pytest.mark.parametrize("leg", LEGS)
def test_only_pairs_that_touch_at_the_nominal_stance_are_left_out(robot, leg):
    """Asked of Pinocchio, for the URDF's own geometry."""
    bodies, model, geometry = robot.bodies[leg], robot.model, pin.GeometryModel(robot.geometry)
    geometry.removeAllCollisionPairs()
    every = [(i, j) for i in range(len(bodies.swing)) for j in range(len(bodies.obstacles))]
    for i, j in every:
        first, second = (geometry.getGeometryId(body.name) for body in (bodies.swing[i], bodies.obstacles[j]))
        geometry.addCollisionPair(pin.CollisionPair(first, second))
    data, geometry_data = model.createData(), geometry.createData()
    pin.computeCollisions(model, data, geometry, geometry_data, stance_configuration(robot.description, model), False)
    touching = {
        pair for pair, result in zip(every, geometry_data.collisionResults, strict=True) if result.isCollision()
    }
    assert set(every) - set(bodies.pairs) == touching
    names = {(bodies.swing[i].name[3:], bodies.obstacles[j].name[:4]) for i, j in touching}
    assert names == {("THIGH_0", "base"), ("THIGH_2", "base")}


@pytest.mark.parametrize("leg", LEGS)
def test_obstacles_are_all_but_the_leg_where_pinocchio_places_them(robot, leg):
    bodies, geometry = robot.bodies[leg], robot.geometry
    names = {item.name for item in geometry.geometryObjects}
    assert {body.name for body in bodies.obstacles} == {name for name in names if not name.startswith(leg)}
    assert {body.name for body in bodies.swing} == {
        name for name in names if name.startswith(leg) and "HIP" not in name
    }
    data, geometry_data = robot.model.createData(), geometry.createData()
    stance = stance_configuration(robot.description, robot.model)
    pin.updateGeometryPlacements(robot.model, data, geometry, geometry_data, stance)
    for body in bodies.obstacles:
        placed = geometry_data.oMg[geometry.getGeometryId(body.name)]
        np.testing.assert_allclose(body.translation, placed.translation, atol=1e-12)
        np.testing.assert_allclose(body.rotation, placed.rotation, atol=1e-12)
