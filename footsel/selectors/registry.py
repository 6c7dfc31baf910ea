"""Selectors by the name that a user types."""

from pathlib import Path

from footsel.errors import UnknownNameError
from footsel.runtime import FootholdSelector
from footsel.selectors.base import Selector
from footsel.selectors.network import NetworkSelector, VerifiedNetworkSelector

SELECTORS = ("nominal", "terrain_only", "oracle", "cnn", "cnn+verify")


def make_selector(name: str, robot: str = "anymal_b", model: str | Path | None = None) -> Selector:
    """A selector by name.

    robot: name of the robot description. model: released model or model folder of the network (default: the robot's).
    Raises UnknownNameError for a name that is not in SELECTORS.
    """
    if name not in SELECTORS:
        raise UnknownNameError("selector", name, SELECTORS)
    if name == "cnn":
        return NetworkSelector(FootholdSelector.load(model or robot))
    # All but the network need the robot model, which the runtime's bare installation does not have.
    from footsel.oracle import Oracle
    from footsel.selectors.exact import OracleSelector
    from footsel.selectors.nominal import NominalSelector
    from footsel.selectors.terrain_only import TerrainOnlySelector

    oracle = Oracle.load(robot)
    if name == "cnn+verify":
        return VerifiedNetworkSelector(FootholdSelector.load(model or robot), oracle)
    layout = oracle.robot.layout
    if name == "oracle":
        return OracleSelector(layout, oracle)
    return NominalSelector(layout) if name == "nominal" else TerrainOnlySelector(layout)
