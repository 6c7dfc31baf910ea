"""A URDF for physics: one link for every body that moves, with Pinocchio's inertias and the robot's collision geometry.

Simulators differ in what they make of fixed joints and of inertias that are not diagonal. Here is nothing to differ
in: what fixed joints connect is one link, and inertial frames are principal axes.
"""

from xml.etree import ElementTree as Xml

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from footsel.errors import InputError
from footsel.robot.robot import Robot

BASE = "base"


def physics_urdf(robot: Robot) -> str:
    """The robot with links `base` and, named after the joint that moves each, twelve more."""
    root = Xml.Element("robot", name=f"{robot.name}_physics")
    links = {0: _link(root, BASE, robot.model.inertias[0])}
    for joint in range(1, robot.model.njoints):
        name = robot.model.names[joint]
        links[joint] = _link(root, name, robot.model.inertias[joint])
        _joint(root, robot, joint)
    for item in robot.geometry.geometryObjects:
        collision = Xml.SubElement(links[item.parentJoint], "collision")
        _origin(collision, item.placement)
        _shape(Xml.SubElement(collision, "geometry"), item)
    return Xml.tostring(root, encoding="unicode")


def _link(root: Xml.Element, name: str, inertia: pin.Inertia) -> Xml.Element:
    """A link whose inertial frame lies in the principal axes."""
    moments, axes = np.linalg.eigh(inertia.inertia)
    axes = axes * np.sign(np.linalg.det(axes))
    link = Xml.SubElement(root, "link", name=name)
    inertial = Xml.SubElement(link, "inertial")
    _origin(inertial, pin.SE3(axes, inertia.lever))
    Xml.SubElement(inertial, "mass", value=repr(float(inertia.mass)))
    Xml.SubElement(
        inertial,
        "inertia",
        ixx=repr(float(moments[0])),
        iyy=repr(float(moments[1])),
        izz=repr(float(moments[2])),
        ixy="0",
        ixz="0",
        iyz="0",
    )
    return link


def _joint(root: Xml.Element, robot: Robot, joint: int) -> None:
    model = robot.model
    parent = model.parents[joint]
    element = Xml.SubElement(root, "joint", name=model.names[joint], type="revolute")
    Xml.SubElement(element, "parent", link=BASE if parent == 0 else model.names[parent])
    Xml.SubElement(element, "child", link=model.names[joint])
    _origin(element, model.jointPlacements[joint])
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    axis = pin.getJointJacobian(model, data, joint, pin.ReferenceFrame.LOCAL)[3:, model.joints[joint].idx_v]
    Xml.SubElement(element, "axis", xyz=_words(axis))
    Xml.SubElement(element, "limit", lower="-10", upper="10", effort="1000", velocity="100")


def _shape(geometry: Xml.Element, item: pin.GeometryObject) -> None:
    shape = item.geometry
    if isinstance(shape, coal.Box):
        Xml.SubElement(geometry, "box", size=_words(2 * shape.halfSide))
    elif isinstance(shape, coal.Sphere):
        Xml.SubElement(geometry, "sphere", radius=repr(float(shape.radius)))
    elif isinstance(shape, coal.Cylinder):
        length = repr(2 * float(shape.halfLength))
        Xml.SubElement(geometry, "cylinder", radius=repr(float(shape.radius)), length=length)
    else:
        raise InputError(
            f"collision geometry {item.name} is a {type(shape).__name__}",
            "walks need a robot of boxes, cylinders and spheres, as anymal_b is",
        )


def _origin(element: Xml.Element, placement: pin.SE3) -> None:
    rpy = pin.rpy.matrixToRpy(placement.rotation)
    Xml.SubElement(element, "origin", xyz=_words(placement.translation), rpy=_words(rpy))


def _words(vector: NDArray[np.float64]) -> str:
    return " ".join(repr(float(value)) for value in vector)
