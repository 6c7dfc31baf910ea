"""Label one leg's local map with the exact oracle: the cost of every cell and the reason why it is no foothold."""

import argparse
from typing import TYPE_CHECKING

from footsel.cli.options import add_map, add_pose, add_robot, load_map, needing, output_file
from footsel.files import replace_file
from footsel.legs import check_leg

if TYPE_CHECKING:
    from pathlib import Path

    from footsel.footholds import BasePose
    from footsel.oracle import Label
    from footsel.terrain import LocalMap

HELP = "cost and reason of every cell under one leg, by the exact oracle"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel label`."""
    add_map(parser)
    parser.add_argument("--leg", type=check_leg, required=True, help="LF, RF, LH or RH")
    add_pose(parser)
    parser.add_argument("--out", type=output_file, required=True, metavar="L.npz", help="the label")
    parser.add_argument("--plot", type=output_file, metavar="P.png", help="also draw heights, cost, reasons and margin")
    add_robot(parser)


def run(args: argparse.Namespace) -> int:
    """Write the label and say how many cells are of each reason."""
    elevation_map = load_map(args)
    if args.plot:
        with needing("--plot", "report"):
            from footsel.comparison.panels import draw_label
    from footsel.footholds import Reason
    from footsel.oracle import Oracle

    oracle = Oracle.load(args.robot)
    layout = oracle.robot.layout
    pose = args.pose.on(elevation_map, layout)
    local_map = layout.local_map(elevation_map, pose, args.leg)
    label = oracle.label(local_map, args.leg, pose.roll, pose.pitch)
    write_label(args.out, label, local_map, args.leg, pose)
    if args.plot:
        draw_label(args.plot, label, local_map, args.leg, layout.nominal_xy(args.leg, pose))
    counts = ", ".join(
        f"{int((label.reason == reason).sum())} {reason.name.lower().replace('_', ' ')}" for reason in Reason
    )
    print(f"{args.out}: {args.leg}, {label.reason.size} cells: {counts}")
    return 0


def write_label(path: "Path", label: "Label", local_map: "LocalMap", leg: str, pose: "BasePose") -> None:
    """Write the label's `.npz`; it appears whole or not at all."""
    import numpy as np

    from footsel.footholds import REASON_NAMES

    def write(temporary: "Path") -> None:
        with temporary.open("wb") as file:
            np.savez_compressed(
                file,
                cost=label.cost_image,
                reason=label.reason,
                reason_names=np.array(REASON_NAMES),
                kinematic_margin=label.kinematic_margin.astype(np.float32),
                terrain_cost=label.terrain_cost.astype(np.float32),
                heights=local_map.heights,
                positions=local_map.positions(),
                leg=np.array(leg),
                pose=np.array(pose.as_list()),
            )

    replace_file(path, write)
