"""A robot on a course in PyBullet, moved by joint torques alone."""

from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.terrain import ElevationMap
from footsel.walking.bullet import BulletWorld, pybullet
from footsel.walking.ground import make_ground
from footsel.walking.simulation.contacts import Contacts, sort_contacts
from footsel.walking.simulation.physics_urdf import BASE, physics_urdf
from footsel.walking.state import RobotState
from footsel.walking.vectors import cross, rotated, rotation

Array = NDArray[np.float64]

GRAVITY = 9.81
#: Of physics and controller alike. [s]
TIME_STEP = 1 / 400
#: Contacts of four feet converge well before this.
SOLVER_ITERATIONS = 20
#: Between the robot's parts and the ground: rubber on stone.
FRICTION = 0.8


class Simulation:
    """Physics of a walk.

    client: the PyBullet world; robot, ground: its body ids. contacts: of the last step. time: in [s].
    """

    def __init__(self, ground: ElevationMap, robot: Robot, base: Array, joints: Array) -> None:
        """Put the robot at rest on a ground without unknown cells.

        base: (4, 4) placement in W. joints: (12,) by LEGS and HAA HFE KFE, in [rad].
        """
        self.client = BulletWorld()
        # Calls made in every step go past the client's own look-up of functions by name.
        self._id = self.client.id
        self.client.setPhysicsEngineParameter(
            fixedTimeStep=TIME_STEP,
            numSolverIterations=SOLVER_ITERATIONS,
            numSubSteps=1,
            enableConeFriction=1,
            deterministicOverlappingPairs=1,
        )
        self.client.setGravity(0, 0, -GRAVITY)
        self.ground = make_ground(self.client, ground.elevation, ground.resolution, ground.position)
        self.robot = self._load(robot)
        self.time = 0.0
        self.contacts = Contacts(np.zeros((4, 3)))
        self._foot_radius = robot.description.foot_radius
        infos = [self.client.getJointInfo(self.robot, i) for i in range(self.client.getNumJoints(self.robot))]
        index = {info[1].decode(): info[0] for info in infos}
        names = [name for leg in LEGS for name in robot.description.joints[leg]]
        self._joints = [index[name] for name in names]
        self._shanks = self._joints[2::3]
        self._link_names = [info[12].decode() for info in infos] + [BASE]
        self._feet_in_shank = [robot.model.frames[robot.foot_frames[leg]].placement.translation.copy() for leg in LEGS]
        self._tune()
        self.reset(base, joints)

    def reset(self, base: Array, joints: Array, velocity: Array | None = None) -> None:
        """Put the robot somewhere else.

        velocity: (18,) base's linear and angular velocity in W and the joints', at rest if not given.
        """
        velocity = np.zeros(18) if velocity is None else velocity
        inertial = base @ self._inertial
        quaternion = pin.Quaternion(inertial[:3, :3]).coeffs()
        self.client.resetBasePositionAndOrientation(self.robot, inertial[:3, 3].tolist(), quaternion.tolist())
        linear = velocity[:3] + np.cross(velocity[3:6], inertial[:3, 3] - base[:3, 3])
        self.client.resetBaseVelocity(self.robot, linear.tolist(), velocity[3:6].tolist())
        self.client.resetJointStatesMultiDof(
            self.robot,
            self._joints,
            [[angle] for angle in joints.tolist()],
            [[rate] for rate in velocity[6:].tolist()],
        )

    def step(self, torques: Array) -> None:
        """Advance by TIME_STEP under joint torques (12,), in [Nm]."""
        pybullet.setJointMotorControlArray(
            self.robot, self._joints, pybullet.TORQUE_CONTROL, forces=torques.tolist(), physicsClientId=self._id
        )
        pybullet.stepSimulation(physicsClientId=self._id)
        self.time += TIME_STEP
        points = pybullet.getContactPoints(self.robot, self.ground, physicsClientId=self._id)
        self.contacts = sort_contacts(points, self._shanks, self._link_names, self.feet, self._foot_radius)

    def state(self) -> RobotState:
        """The true state."""
        position, quaternion = pybullet.getBasePositionAndOrientation(self.robot, physicsClientId=self._id)
        linear, angular = pybullet.getBaseVelocity(self.robot, physicsClientId=self._id)
        inertial = np.eye(4)
        inertial[:3, :3] = rotation(quaternion)
        inertial[:3, 3] = position
        base = inertial @ self._inertial_inverse
        states = pybullet.getJointStates(self.robot, self._joints, physicsClientId=self._id)
        return RobotState(
            time=self.time,
            base=base,
            linear=linear + cross(angular, (base[:3, 3] - inertial[:3, 3]).tolist()),
            angular=np.array(angular),
            joints=np.array([state[0] for state in states]),
            joint_velocities=np.array([state[1] for state in states]),
            foot_forces=self.contacts.foot_forces,
        )

    def feet(self) -> list[tuple[float, float, float]]:
        """Four true foot centres (3,) by LEGS, in W, in [m]."""
        states = pybullet.getLinkStates(self.robot, self._shanks, physicsClientId=self._id)
        centres = []
        for state, foot in zip(states, self._feet_in_shank, strict=True):
            dx, dy, dz = rotated(state[5], foot)
            x, y, z = state[4]
            centres.append((x + dx, y + dy, z + dz))
        return centres

    def foot_contact_velocities(self) -> Array:
        """(4, 3) velocity of the feet's material where they touch the ground, by LEGS, in W, in [m/s]."""
        states = pybullet.getLinkStates(self.robot, self._shanks, computeLinkVelocity=1, physicsClientId=self._id)
        velocities = np.zeros((4, 3))
        for k, (state, centre) in enumerate(zip(states, self.feet(), strict=True)):
            lever = [
                centre[axis] - self._foot_radius * self.contacts.foot_normals[k][axis] - state[0][axis]
                for axis in range(3)
            ]
            velocities[k] = state[6] + cross(state[7], lever)
        return velocities

    def close(self) -> None:
        """End the simulation."""
        self.client.disconnect()

    def __enter__(self) -> "Simulation":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _load(self, robot: Robot) -> int:
        with TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(physics_urdf(robot), encoding="utf-8")
            flags = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER
            return int(self.client.loadURDF(str(path), flags=flags))

    def _tune(self) -> None:
        """Nothing moves a joint but its torque; friction is a product, so the ground's is 1."""
        self.client.setJointMotorControlArray(
            self.robot, self._joints, pybullet.VELOCITY_CONTROL, forces=[0.0] * len(self._joints)
        )
        # In a call of its own: a link is told nothing of its surface in one that is about the whole body as well.
        for link in range(-1, len(self._joints)):
            self.client.changeDynamics(
                self.robot, link, lateralFriction=FRICTION, rollingFriction=0.0, spinningFriction=0.0, restitution=0.0
            )
        for link in range(-1, len(self._joints)):
            self.client.changeDynamics(
                self.robot, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, maxJointVelocity=1e3
            )
        # Sleeping bodies would stop to feel torques.
        self.client.changeDynamics(self.robot, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
        self.client.changeDynamics(self.ground, -1, lateralFriction=1.0, restitution=0.0)
        position, quaternion = self.client.getDynamicsInfo(self.robot, -1)[3:5]
        self._inertial = np.eye(4)
        self._inertial[:3, :3] = rotation(quaternion)
        self._inertial[:3, 3] = position
        self._inertial_inverse = np.linalg.inv(self._inertial)
