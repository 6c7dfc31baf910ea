"""A URDF in which every collision body is a link of its own, so that an engine names the bodies that touch.

Only frames, joints and primitives are taken over. Inertias are left out: PyBullet places links by their centres of
mass, and without them these are the frames that the URDF names.
"""

from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree as Xml

import coal
import numpy as np
import pinocchio as pin

from footsel.robot.collision_geometry import Body

TRIMMED = "_trimmed"


def split_urdf(path: Path, trimmed: Iterable[tuple[str, Body]]) -> str:
    """The URDF at `path` with links `LINK_0`, `LINK_1`... for the collision bodies of `LINK`.

    trimmed: (link, body) cylinders and capsules that are added as links `BODY_trimmed`, placed in the frame of `link`.
    """
    source = Xml.parse(path).getroot()
    robot = Xml.Element("robot", name=f"{source.get('name')}_bodies")
    for link in source.findall("link"):
        name = link.get("name", "")
        _link(robot, name)
        for number, collision in enumerate(link.findall("collision")):
            _fixed_body(robot, name, f"{name}_{number}", collision)
    for joint in source.findall("joint"):
        copy = Xml.SubElement(robot, "joint", joint.attrib)
        for tag in ("parent", "child", "origin", "axis"):
            copy.extend(joint.findall(tag))
        if joint.get("type") == "revolute":
            Xml.SubElement(copy, "limit", lower="-10", upper="10", effort="1", velocity="1")
    for link_name, body in trimmed:
        _fixed_body(robot, link_name, body.name + TRIMMED, _collision(body))
    return Xml.tostring(robot, encoding="unicode")


def _link(robot: Xml.Element, name: str) -> Xml.Element:
    link = Xml.SubElement(robot, "link", name=name)
    inertial = Xml.SubElement(link, "inertial")
    Xml.SubElement(inertial, "mass", value="1")
    Xml.SubElement(inertial, "inertia", ixx="1", ixy="0", ixz="0", iyy="1", iyz="0", izz="1")
    return link


def _fixed_body(robot: Xml.Element, parent: str, name: str, collision: Xml.Element) -> None:
    _link(robot, name).append(collision)
    joint = Xml.SubElement(robot, "joint", name=f"{name}_fixed", type="fixed")
    Xml.SubElement(joint, "parent", link=parent)
    Xml.SubElement(joint, "child", link=name)


def _collision(body: Body) -> Xml.Element:
    collision = Xml.Element("collision")
    rpy = pin.rpy.matrixToRpy(body.rotation)
    Xml.SubElement(collision, "origin", xyz=_words(body.translation), rpy=_words(rpy))
    kind = {coal.Cylinder: "cylinder", coal.Capsule: "capsule"}[type(body.shape)]
    geometry = Xml.SubElement(collision, "geometry")
    Xml.SubElement(geometry, kind, radius=repr(float(body.shape.radius)), length=repr(2 * float(body.shape.halfLength)))
    return collision


def _words(vector: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    return " ".join(repr(float(value)) for value in vector)
