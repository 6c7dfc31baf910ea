"""Robot descriptions, leg kinematics and collision geometry."""

from typing import TYPE_CHECKING, Any

from footsel.robot.description import RobotDescription, read_description, robot_names

if TYPE_CHECKING:
    from footsel.robot.robot import Robot, load_robot

__all__ = ["Robot", "RobotDescription", "load_robot", "read_description", "robot_names"]


def __getattr__(name: str) -> Any:
    """Pinocchio and coal are loaded when a robot is, not to list the names of the robots."""
    if name in ("Robot", "load_robot"):
        from footsel.robot import robot

        return getattr(robot, name)
    raise AttributeError(name)
