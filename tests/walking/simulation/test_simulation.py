"""The simulated robot is Pinocchio's: accelerations, inertias, feet; its ground is the map; and it repeats itself."""

import numpy as np
import pinocchio as pin
import pytest

from footsel.legs import LEGS, mirror_of
from footsel.robot import load_robot
from footsel.terrain import ElevationMap
from footsel.walking.bullet import pybullet
from footsel.walking.control.dynamics import Dynamics
from footsel.walking.simulation import TIME_STEP, Simulation
from footsel.walking.simulation.simulation import FRICTION

ROBOT = load_robot("anymal_b")
FLAT = ElevationMap(np.zeros((60, 60), dtype=np.float32), 0.05)
STANCE = np.concatenate([ROBOT.description.stance[leg] for leg in LEGS])


def placed(x=0.0, y=0.0, z=0.0, roll=0.0, pitch=0.0, yaw=0.0):
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = pin.rpy.rpyToMatrix(roll, pitch, yaw), (x, y, z)
    return base


@pytest.fixture
def simulation():
    """The robot high above level ground."""
    with Simulation(FLAT, ROBOT, placed(z=3.0), STANCE) as world:
        yield world


def step(world, base, joints, velocity, torques):
    """(18,) acceleration in one step: linear of the base's origin, angular, both in W, and the joints'."""
    world.reset(base, joints, velocity)
    before = world.state()
    world.step(torques)
    after = world.state()
    parts = ("linear", "angular", "joint_velocities")
    return np.concatenate([getattr(after, part) - getattr(before, part) for part in parts]) / TIME_STEP


def by_pinocchio(world, base, joints, velocity, torques):
    """The same from the equations of motion."""
    world.reset(base, joints, velocity)
    state = world.state()
    motion = Dynamics(ROBOT).at(state)
    twist = np.linalg.solve(motion.mass, np.concatenate([np.zeros(6), torques]) - motion.bias)
    turn = base[:3, :3]
    # The acceleration of the base's origin, not that of its twist.
    linear = turn @ twist[:3] + np.cross(state.angular, state.linear)
    return np.concatenate([linear, turn @ twist[3:6], twist[6:]])


@pytest.mark.parametrize("seed", range(8))
def test_accelerations_are_pinocchio_s(simulation, seed):
    rng = np.random.default_rng(seed)
    base = placed(*rng.uniform(-1, 1, 2), 3.0, *rng.uniform(-0.6, 0.6, 2), rng.uniform(-3, 3))
    joints = STANCE + rng.uniform(-0.5, 0.5, 12)
    torques = rng.uniform(-30, 30, 12)
    expected = by_pinocchio(simulation, base, joints, np.zeros(18), torques)
    found = step(simulation, base, joints, np.zeros(18), torques)
    np.testing.assert_allclose(found, expected, rtol=0.01, atol=0.01 * np.abs(expected).max())

    # Moving, a step of finite length sees the velocities change.
    velocity = rng.uniform(-0.5, 0.5, 18)
    expected = by_pinocchio(simulation, base, joints, velocity, torques)
    found = step(simulation, base, joints, velocity, torques)
    np.testing.assert_allclose(found, expected, rtol=0.05, atol=0.03 * np.abs(expected).max())


def test_states_are_what_they_were_set_to(simulation):
    rng = np.random.default_rng(0)
    base, joints, velocity = placed(0.3, -0.2, 3.0, 0.3, -0.2, 1.0), STANCE + 0.1, rng.uniform(-1, 1, 18)
    simulation.reset(base, joints, velocity)
    state = simulation.state()
    np.testing.assert_allclose(state.base, base, atol=1e-9)
    np.testing.assert_allclose(np.concatenate([state.linear, state.angular]), velocity[:6], atol=1e-9)
    np.testing.assert_allclose(state.joints, joints)
    np.testing.assert_allclose(state.joint_velocities, velocity[6:])
    np.testing.assert_allclose(simulation.feet(), Dynamics(ROBOT).at(state).feet, atol=1e-6)


def test_the_mirrored_robot_moves_like_the_mirror_image(simulation):
    rng = np.random.default_rng(3)
    joints, torques = STANCE + rng.uniform(-0.3, 0.3, 12), rng.uniform(-20, 20, 12)
    velocity = rng.uniform(-0.5, 0.5, 18)

    def swapped(values):
        """Values (12,) of the mirrored legs: abduction turns the other way."""
        legs = values.reshape(4, 3)[[LEGS.index(mirror_of(leg)) for leg in LEGS]]
        return (legs * [-1, 1, 1]).ravel()

    across = np.array([1, -1, 1, -1, 1, -1])
    mirrored = np.concatenate([velocity[:6] * across, swapped(velocity[6:])])
    found = step(simulation, placed(z=3.0, roll=0.2, pitch=0.1, yaw=0.4), joints, velocity, torques)
    image = step(simulation, placed(z=3.0, roll=-0.2, pitch=0.1, yaw=-0.4), swapped(joints), mirrored, swapped(torques))
    # ANYmal's inertias are symmetric to a few parts in a thousand.
    expected = np.concatenate([found[:6] * across, swapped(found[6:])])
    np.testing.assert_allclose(image, expected, atol=0.02 * np.abs(found).max())


def test_feet_on_the_ground_are_told_from_a_base_that_lies_on_it():
    standing = -ROBOT.layout.nominal_feet["LF"][2] - 1e-3
    with Simulation(FLAT, ROBOT, placed(z=standing), STANCE) as world:
        world.step(np.zeros(12))
        assert (world.contacts.foot_forces[:, 2] > 0).all() and not world.contacts.others
        np.testing.assert_allclose(world.contacts.foot_normals, np.tile([0, 0, 1], (4, 1)), atol=1e-6)
    folded = np.array([0, 1.5, -2.3] * 2 + [0, -1.5, 2.3] * 2)
    with Simulation(FLAT, ROBOT, placed(z=0.3), folded) as world:
        for _ in range(200):
            world.step(np.zeros(12))
        assert world.contacts.others, "a robot without torques lies on more than its feet"


def test_it_repeats_itself_to_the_last_bit():
    def fall():
        with Simulation(FLAT, ROBOT, placed(z=0.6, roll=0.1), STANCE) as world:
            for tick in range(150):
                world.step(20 * np.sin(0.1 * tick + np.arange(12)))
            state = world.state()
        return state.base.tobytes() + state.joints.tobytes() + state.foot_forces.tobytes()

    assert fall() == fall()


@pytest.mark.parametrize("direction", [0.0, 0.6, 1.6, 4.0])
def test_feet_slip_at_the_friction_that_is_told_and_not_before(direction):
    """With its joints held, the robot is pushed along the ground at the height of its feet."""
    push = np.array([np.cos(direction), np.sin(direction), 0.0])
    ratio, speed = {}, {}
    for share in (0.85, 1.25):
        with Simulation(FLAT, ROBOT, placed(z=0.47), STANCE) as world:
            world.client.setJointMotorControlArray(
                world.robot, world._joints, pybullet.VELOCITY_CONTROL, targetVelocities=[0.0] * 12, forces=[500.0] * 12
            )
            for _ in range(400):
                world.step(np.zeros(12))
            force = share * FRICTION * world.state().foot_forces[:, 2].sum() * push
            for _ in range(100):
                where = np.array(world.feet()).mean(axis=0)
                world.client.applyExternalForce(world.robot, -1, force.tolist(), where.tolist(), pybullet.WORLD_FRAME)
                world.step(np.zeros(12))
            forces = world.state().foot_forces
            ratio[share] = np.linalg.norm(forces[:, :2].sum(axis=0)) / forces[:, 2].sum()
            speed[share] = np.linalg.norm(world.foot_contact_velocities(), axis=1).mean()
    assert speed[0.85] < 0.05 and speed[1.25] > 0.2
    assert ratio[1.25] == pytest.approx(FRICTION, rel=0.06)
