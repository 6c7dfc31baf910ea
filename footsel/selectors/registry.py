"""Selectors by the name that a user types."""

from pathlib import Path

from footsel.errors import MissingExtraError, UnknownNameError
from footsel.runtime import FootholdSelector
from footsel.selectors.base import Selector
from footsel.selectors.network import NetworkSelector, VerifiedNetworkSelector

#: Names of footsel.selectors.classic, which loads scipy.
CLASSIC = ("krotkov", "chen_kumar", "barasuol", "rebula", "kolter", "roennau", "traversability")
SELECTORS = ("nominal", "terrain_only", *CLASSIC, "oracle", "cnn", "cnn:int8", "cnn+verify")


def make_selector(name: str, robot: str = "anymal_b", model: str | Path | None = None) -> Selector:
    """A selector by name.

    robot: name of the robot description. model: released model or model folder of the network (default: the robot's).
    Raises UnknownNameError for a name that is not in SELECTORS, ModelError for a model that cannot be read or has no
    8-bit variant.
    """
    if name not in SELECTORS:
        raise UnknownNameError("selector", name, SELECTORS)
    if name == "cnn":
        return NetworkSelector(FootholdSelector.load(model or robot))
    if name == "cnn:int8":
        return NetworkSelector(FootholdSelector.load(model or robot, "int8"))
    if name in ("oracle", "cnn+verify"):
        return _exact_selector(name, robot, model)
    return _ground_selector(name, robot)


def _exact_selector(name: str, robot: str, model: str | Path | None) -> Selector:
    """One that asks the oracle."""
    from footsel.oracle import Oracle
    from footsel.selectors.exact import OracleSelector

    oracle = Oracle.load(robot)
    if name == "cnn+verify":
        return VerifiedNetworkSelector(FootholdSelector.load(model or robot), oracle)
    return OracleSelector(oracle.robot.layout, oracle)


def _ground_selector(name: str, robot: str) -> Selector:
    """One that needs no more of the robot than where its legs sit."""
    # The robot model is not part of the runtime's bare installation.
    from footsel.robot import load_robot

    layout = load_robot(robot).layout
    if name == "nominal":
        from footsel.selectors.nominal import NominalSelector

        return NominalSelector(layout)
    if name == "terrain_only":
        from footsel.selectors.terrain_only import TerrainOnlySelector

        return TerrainOnlySelector(layout)
    try:
        from footsel.selectors.classic import SCORERS
    except ImportError as error:
        raise MissingExtraError("the classic scorers", "oracle", error.name or "scipy") from None
    return SCORERS[name](layout)
