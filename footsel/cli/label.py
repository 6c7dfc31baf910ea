"""Label one leg's local map with the exact oracle: the cost of every cell and the reason why it is no foothold."""

import argparse
from typing import TYPE_CHECKING

from footsel.cli.numbers import finite_number, whole_number
from footsel.cli.options import add_map, add_pose, add_robot, load_map, needing, output_file
from footsel.errors import InputError
from footsel.files import replace_file
from footsel.legs import check_leg

if TYPE_CHECKING:
    from pathlib import Path

    from footsel.footholds import BasePose
    from footsel.oracle import Label
    from footsel.oracle.explanation import Contacts
    from footsel.terrain import LocalMap

HELP = "cost and reason of every cell under one leg, by the exact oracle"

FILE_HELP = """\
what L.npz holds, for the 40x40 cells (i along the heading, j to the left) of the leg's local map:
  cost              uint8, 0 to 254; 255 where no foot may stand
  reason            uint8 indexing reason_names: the first constraint that fails
  kinematic_margin  distance of the foot to the border of its workspace [m], NaN where infeasible
  terrain_cost      0 to 1, NaN where unknown
  joint_angles      (40, 40, 3) HAA HFE KFE [rad], NaN where unknown or out of range
  touching          (40, 40, 2) uint8 indexing body_names: the leg's body and what it hits; the empty name if nothing
  heights           relative to the hip point [m]; positions (40, 40, 3) in the world [m]
  leg, pose         what was asked for
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel label`."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = FILE_HELP
    add_map(parser)
    parser.add_argument("--leg", type=check_leg, required=True, help="LF, RF, LH or RH")
    add_pose(parser)
    parser.add_argument("--out", type=output_file, metavar="L.npz", help="the label, with what explains it")
    parser.add_argument(
        "--plot",
        type=output_file,
        metavar="P.png",
        help="draw terrain, reasons, the bodies that meet, cost, margin and joint angles",
    )
    cell = parser.add_mutually_exclusive_group()
    cell.add_argument(
        "--cell", type=whole_number(0), nargs=2, metavar=("I", "J"), help="explain this cell in words, 0 0 to 39 39"
    )
    cell.add_argument(
        "--at", type=finite_number, nargs=2, metavar=("X", "Y"), help="explain the cell at this place of the world [m]"
    )
    add_robot(parser)


def run(args: argparse.Namespace) -> int:
    """Write what was asked for; say how many cells are of each reason, or why one cell is what it is."""
    if not (args.out or args.plot or args.cell or args.at):
        raise InputError("nothing to do", "give --out L.npz, --plot P.png, --cell I J or --at X Y")
    elevation_map = load_map(args)
    if args.plot:
        with needing("--plot", "report"):
            from footsel.comparison.label_sheet import draw_label_sheet
    from footsel.footholds import Reason
    from footsel.oracle import Oracle
    from footsel.oracle.explanation import LegExplainer, cell_at

    oracle = Oracle.load(args.robot)
    layout = oracle.robot.layout
    pose = args.pose.on(elevation_map, layout)
    local_map = layout.local_map(elevation_map, pose, args.leg)
    label = oracle.label(local_map, args.leg, pose.roll, pose.pitch)
    explainer = LegExplainer(oracle.robot, args.leg)
    explanation = None
    if args.cell or args.at:
        cell = tuple(args.cell) if args.cell else cell_at(local_map, *args.at)
        explanation = explainer.cell(label, local_map, pose.roll, pose.pitch, cell)
    if args.out or args.plot:
        contacts = explainer.contacts(label, local_map, pose.roll, pose.pitch)
    if args.out:
        write_label(args.out, label, contacts, local_map, args.leg, pose)
    if args.plot:
        draw_label_sheet(args.plot, label, contacts, local_map, args.leg, layout.nominal_xy(args.leg, pose))
    if args.out or args.plot:
        counts = ", ".join(
            f"{int((label.reason == reason).sum())} {reason.name.lower().replace('_', ' ')}" for reason in Reason
        )
        print(f"{args.out or args.plot}: {args.leg}, {label.reason.size} cells: {counts}")
    if explanation:
        print(explanation)
    return 0


def write_label(
    path: "Path", label: "Label", contacts: "Contacts", local_map: "LocalMap", leg: str, pose: "BasePose"
) -> None:
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
                joint_angles=label.joint_angles.astype(np.float32),
                touching=contacts.touching,
                body_names=np.array(contacts.body_names),
                heights=local_map.heights,
                positions=local_map.positions(),
                leg=np.array(leg),
                pose=np.array(pose.as_list()),
            )

    replace_file(path, write)
