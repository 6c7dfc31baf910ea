"""The selectors that are compared, and the oracle that judges them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from footsel.errors import ModelError
from footsel.footholds import LegLayout
from footsel.legs import LEGS
from footsel.oracle import Oracle
from footsel.runtime import FootholdSelector
from footsel.selectors import Selector, make_selector
from footsel.selectors.network import NetworkSelector
from footsel.selectors.registry import CLASSIC

#: Selectors whose costs the report draws beside the oracle's, the first that takes part.
SCORERS = ("cnn", "cnn:int8", "cnn+verify", "terrain_only", *CLASSIC)


@dataclass(frozen=True, eq=False)
class Contestants:
    """selectors: by name, in the order asked for. oracle: the judge."""

    robot: str
    oracle: Oracle
    selectors: Mapping[str, Selector]

    @property
    def layout(self) -> LegLayout:
        """Hip points and nominal feet of the robot."""
        return self.oracle.robot.layout

    @property
    def network(self) -> FootholdSelector | None:
        """The network of `cnn`, if it takes part; its cells are judged too."""
        selector = self.selectors.get("cnn")
        return selector.runtime if isinstance(selector, NetworkSelector) else None

    @property
    def scorer(self) -> str | None:
        """Name of the selector whose costs are drawn, if any has costs of its own."""
        return next((name for name in SCORERS if name in self.selectors), None)


@cache
def load_contestants(robot: str, names: tuple[str, ...], model: Path | None = None) -> Contestants:
    """Make the selectors `names` of a robot once per process.

    model: model folder of the network (default: the robot's released one).
    Raises UnknownNameError for another name, ModelError for a model that is missing or made for another robot.
    """
    oracle = Oracle.load(robot)
    selectors = {name: make_selector(name, robot, model) for name in names}
    for selector in selectors.values():
        _check_layout(selector.layout, oracle.robot.layout, robot)
    return Contestants(robot, oracle, selectors)


def unique(names: Sequence[str]) -> tuple[str, ...]:
    """Each name once, in the order given."""
    return tuple(dict.fromkeys(names))


def _check_layout(layout: LegLayout, expected: LegLayout, robot: str) -> None:
    """Cells are compared by their index: a model of another robot or another description would have others."""
    same = np.isclose(layout.resolution, expected.resolution) and all(
        np.allclose(layout.hips[leg], expected.hips[leg], atol=1e-6)
        and np.allclose(layout.nominal_feet[leg], expected.nominal_feet[leg], atol=1e-6)
        for leg in LEGS
    )
    if not same:
        raise ModelError(f"the model was made for another description than {robot}", "export a model for this robot")
