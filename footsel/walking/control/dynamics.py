"""The floating robot's equations of motion, `M a + h = S^T tau + J^T f`, by Pinocchio."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.legs import LEGS
from footsel.robot.robot import Robot
from footsel.walking.state import RobotState

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Motion:
    """Terms of the equations of motion at one state.

    Velocities and accelerations (18,) are the base's twist in the base frame, linear first, and the joints' by LEGS and
    HAA HFE KFE.

    mass: (18, 18). bias: (18,) gravity, Coriolis and centrifugal terms.
    feet, feet_velocity: (4, 3) centres of the foot spheres in W, by LEGS, in [m] and [m/s].
    jacobian: (12, 18) of the feet, in W. drift: (12,) acceleration of the feet at zero joint and base acceleration.
    com: (3,) centre of mass in W, in [m].
    """

    mass: Array
    bias: Array
    feet: Array
    feet_velocity: Array
    jacobian: Array
    drift: Array
    com: Array


class Dynamics:
    """Pinocchio's model of a robot on a floating base, its joints in our order."""

    def __init__(self, robot: Robot) -> None:
        model = pin.buildModelFromUrdf(str(robot.description.urdf_path), pin.JointModelFreeFlyer())
        joints = [model.joints[model.getJointId(name)] for leg in LEGS for name in robot.description.joints[leg]]
        self._feet = []
        for leg in LEGS:
            fixed = robot.model.frames[robot.foot_frames[leg]]
            knee = model.getJointId(robot.description.joints[leg][2])
            frame = pin.Frame(f"{leg}_foot_centre", knee, fixed.placement, pin.FrameType.OP_FRAME)
            self._feet.append(model.addFrame(frame))
        self._model, self._data = model, model.createData()
        self._in_q = np.array([joint.idx_q for joint in joints])
        in_v = np.array([joint.idx_v for joint in joints])
        #: Where each of our velocities stands among Pinocchio's.
        self._order = np.concatenate([np.arange(6), in_v])
        self._order_2d = np.ix_(self._order, self._order)
        self._nothing = np.zeros(model.nv)

    @property
    def total_mass(self) -> float:
        """Of the robot, in [kg]."""
        return float(pin.computeTotalMass(self._model))

    def at(self, state: RobotState) -> Motion:
        """All terms at a state."""
        model, data, order = self._model, self._data, self._order
        q, v = self.configuration(state), self.velocity(state)
        pin.forwardKinematics(model, data, q, v, self._nothing)
        pin.updateFramePlacements(model, data)
        pin.computeJointJacobians(model, data)
        drift, jacobian, feet = np.empty(12), np.empty((12, model.nv)), np.empty((4, 3))
        for k, frame in enumerate(self._feet):
            rows = slice(3 * k, 3 * k + 3)
            feet[k] = data.oMf[frame].translation
            jacobian[rows] = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)[:3]
            drift[rows] = pin.getFrameClassicalAcceleration(model, data, frame, pin.LOCAL_WORLD_ALIGNED).linear
        bias = pin.nonLinearEffects(model, data, q, v)[order]
        mass = pin.crba(model, data, q, pin.Convention.WORLD)[self._order_2d]
        com = pin.centerOfMass(model, data, q)
        return Motion(
            mass=mass,
            bias=bias,
            feet=feet,
            feet_velocity=(jacobian @ v).reshape(4, 3),
            jacobian=np.ascontiguousarray(jacobian[:, order]),
            drift=drift,
            com=com.copy(),
        )

    def configuration(self, state: RobotState) -> Array:
        """(19,) Pinocchio's configuration."""
        q = np.empty(self._model.nq)
        q[:3] = state.base[:3, 3]
        q[3:7] = pin.Quaternion(state.base[:3, :3]).coeffs()
        q[self._in_q] = state.joints
        return q

    def velocity(self, state: RobotState) -> Array:
        """(18,) Pinocchio's velocity, in its order."""
        v = np.empty(self._model.nv)
        v[:3] = state.linear @ state.base[:3, :3]
        v[3:6] = state.angular @ state.base[:3, :3]
        v[self._order[6:]] = state.joint_velocities
        return v
