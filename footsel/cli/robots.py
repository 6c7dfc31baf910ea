"""List the robots that footsel knows: their legs, joint limits, local map, and whether a model is released."""

import argparse
import math
from typing import TYPE_CHECKING

from footsel.errors import MissingExtraError

if TYPE_CHECKING:
    from footsel.footholds import LegLayout

HELP = "the robots there are, and which have a released model"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """`footsel robots` takes none."""
    del parser


def run(args: argparse.Namespace) -> int:
    """Print the list."""
    del args
    from footsel.robot import robot_names

    for name in robot_names():
        _print_robot(name)
    return 0


def _print_robot(name: str) -> None:
    from footsel.legs import LEGS, PAIRS, pair_of
    from footsel.robot import read_description
    from footsel.runtime.model_folder import available_models, available_variants, find_model_folder
    from footsel.terrain import CELLS

    released = name in available_models()
    robot = read_description(name)
    pairs = ", ".join(f"{pair} ({' '.join(leg for leg in LEGS if pair_of(leg) == pair)})" for pair in PAIRS)
    symmetric = "; right mirrors left" if robot.symmetric else ""
    print(name)
    print(f"  pairs      {pairs}{symmetric}")
    print(f"  local map  {CELLS}x{CELLS} cells of {robot.resolution:g} m, {robot.height_range:g} m deep")
    print(f"  foot       sphere of radius {robot.foot_radius:g} m")
    if released:
        folder = find_model_folder(name)
        print(f"  model      {folder} ({', '.join(available_variants(folder))})")
    else:
        print("  model      none released; make one with footsel dataset, train and export")
    print(f"  limits     {robot.limits_name}, in degrees")
    layout = _layout(name, released)
    for leg in LEGS:
        limits = "  ".join(
            f"{joint} {math.degrees(low):.0f}..{math.degrees(high):.0f}"
            for joint, (low, high) in zip(("HAA", "HFE", "KFE"), robot.limits[leg], strict=True)
        )
        point = "" if layout is None else f"  hip point {_metres(layout.hips[leg])} m"
        print(f"    {leg}  {limits}{point}")
    if layout is None:
        print("  hip points need the robot model: pip install 'footsel[oracle]'")


def _layout(name: str, released: bool) -> "LegLayout | None":
    """From the released model if there is one, which needs no robot model; else from the robot model, if installed."""
    if released:
        from footsel.runtime import FootholdSelector

        return FootholdSelector.load(name).layout
    try:
        from footsel.robot import load_robot

        return load_robot(name).layout
    except MissingExtraError:
        return None


def _metres(point: "object") -> str:
    import numpy as np

    return " ".join(f"{value:+.3f}" for value in np.asarray(point, dtype=float))
