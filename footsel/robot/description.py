"""A robot description: one TOML file per robot, every number with its source beside it."""

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from footsel.errors import InputError, MissingExtraError, UnknownNameError
from footsel.legs import LEGS, pair_of

JOINT_KINDS = ("HAA", "HFE", "KFE")


@dataclass(frozen=True)
class RobotDescription:
    """What the TOML file says.

    urdf: path below a `share` folder of the Python environment.
    joints, stance, limits: per leg, ordered HAA HFE KFE; angles in [rad].
    foot_geometry: name of the foot sphere in the URDF's collision model. foot_radius, foot_trim in [m].
    resolution, height_range: of the local map, in [m].
    margin_max: per leg, in [m]; right legs fall back to their mirror image.
    symmetric: the right side mirrors the left.
    """

    name: str
    urdf: str
    symmetric: bool
    resolution: float
    height_range: float
    foot_geometry: Mapping[str, str]
    foot_radius: float
    foot_trim: float
    joints: Mapping[str, tuple[str, str, str]]
    stance: Mapping[str, tuple[float, float, float]]
    limits_name: str
    limits: Mapping[str, tuple[tuple[float, float], ...]]
    margin_max: Mapping[str, float]

    @property
    def urdf_path(self) -> Path:
        """The URDF in this environment; raises MissingExtraError if its package is not installed."""
        return share_folder(self.urdf) / self.urdf


def robot_names() -> tuple[str, ...]:
    """Names of the robots that have a description."""
    folder = resources.files("footsel.robot") / "descriptions"
    return tuple(sorted(entry.name[: -len(".toml")] for entry in folder.iterdir() if entry.name.endswith(".toml")))


def read_description(name: str, limits: str | None = None) -> RobotDescription:
    """The description of a robot, with one of its named limit sets (default: the one it names itself)."""
    if name not in robot_names():
        raise UnknownNameError("robot", name, robot_names())
    text = (resources.files("footsel.robot") / "descriptions" / f"{name}.toml").read_text(encoding="utf-8")
    values = _parse_toml(text)
    sets = {key: value for key, value in values["limits"].items() if isinstance(value, dict)}
    limits = limits or values["limits"]["default"]
    if limits not in sets:
        raise UnknownNameError(f"limit set of {name}", limits, sets)
    return RobotDescription(
        name=values["name"],
        urdf=values["urdf"],
        symmetric=values["symmetric"],
        resolution=values["local_map"]["resolution"],
        height_range=values["local_map"]["height_range"],
        foot_geometry={leg: values["foot"]["geometry"].format(leg=leg) for leg in LEGS},
        foot_radius=values["foot"]["radius"],
        foot_trim=values["foot"]["trim"],
        joints={leg: tuple(values["joints"][kind].format(leg=leg) for kind in JOINT_KINDS) for leg in LEGS},
        stance={leg: tuple(values["stance"][leg]) for leg in LEGS},
        limits_name=limits,
        limits={leg: tuple(_limit_of(sets[limits][kind], leg) for kind in JOINT_KINDS) for leg in LEGS},
        margin_max=values["margin_max"][limits],
    )


def share_folder(relative: str) -> Path:
    """The `share` folder of the environment that holds `relative`."""
    candidates = [Path(path) / "cmeel.prefix" / "share" for path in sys.path] + [Path(sys.prefix) / "share"]
    for folder in candidates:
        if (folder / relative).exists():
            return folder
    raise MissingExtraError(f"the robot model {relative}", "oracle", "example-robot-data")


def _limit_of(value: Any, leg: str) -> tuple[float, float]:
    """One pair for all legs, one per front/hind pair, or one per leg."""
    if isinstance(value, dict):
        value = value[leg] if leg in value else value[pair_of(leg)]
    low, high = value
    if low >= high:
        raise InputError(f"joint limits {value} of {leg}", "the lower limit comes first")
    return float(low), float(high)


def _parse_toml(text: str) -> dict[str, Any]:
    """The standard library's parser, or its backport on Python 3.10."""
    if sys.version_info >= (3, 11):
        import tomllib

        return tomllib.loads(text)
    try:
        import tomli
    except ImportError:
        raise MissingExtraError("reading a robot description on Python 3.10", "oracle", "tomli") from None
    parsed: dict[str, Any] = tomli.loads(text)
    return parsed
