"""Choose a foothold for each leg and print them as JSON.

A leg without a foothold has the status "none" and a reason; that is an answer, not an error.
"""

import argparse
import json
from pathlib import Path

from footsel.cli.numbers import whole_number
from footsel.cli.options import add_legs, add_map, add_pose, add_robot, load_map, needing, output_file
from footsel.errors import InputError

HELP = "a foothold for each leg, as JSON"

#: The names of footsel.selectors, which loads onnxruntime, too slow to show help.
#: The last seven are classic terrain scorers.
SELECTORS = (
    "cnn",
    "cnn+verify",
    "cnn:int8",
    "oracle",
    "nominal",
    "terrain_only",
    "krotkov",
    "chen_kumar",
    "barasuol",
    "rebula",
    "kolter",
    "roennau",
    "traversability",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel select`."""
    add_map(parser)
    add_pose(parser)
    parser.add_argument(
        "--selector",
        default="cnn",
        metavar="NAME",
        help=f"{', '.join(SELECTORS)} (default: %(default)s)",
    )
    add_legs(parser)
    parser.add_argument(
        "--top-k",
        type=whole_number(1),
        default=3,
        metavar="K",
        help="candidates per leg, the chosen one and its alternatives (default: %(default)s)",
    )
    parser.add_argument(
        "--model", type=Path, metavar="PATH", help="model folder of cnn (default: the robot's released one)"
    )
    parser.add_argument("--plot", type=output_file, metavar="P.png", help="also draw the map, the legs and the picks")
    add_robot(parser)


def run(args: argparse.Namespace) -> int:
    """Print the footholds."""
    elevation_map = load_map(args)
    if args.plot:
        with needing("--plot", "report"):
            from footsel.comparison.panels import draw_selection
    from footsel.selectors import make_selector

    selector = make_selector(args.selector, args.robot, args.model)
    runtime = getattr(selector, "runtime", None)
    if runtime is not None and runtime.robot != args.robot:
        raise InputError(
            f"{args.model} is a model of {runtime.robot}, not of {args.robot}", "give --robot or another model"
        )
    pose = args.pose.on(elevation_map, selector.layout)
    # The first call reads tables or lays out memory, which a robot does once: the second one is timed.
    selector.select(elevation_map, pose, args.legs)
    footholds, timing = selector.select_timed(elevation_map, pose, args.legs, top_k=args.top_k)
    if args.plot:
        draw_selection(args.plot, elevation_map, pose, selector.layout, footholds)
    answer = {
        "robot": args.robot,
        "selector": args.selector,
        "pose": pose.as_list(),
        "footholds": {leg: foothold.to_dict() for leg, foothold in footholds.items()},
        "time_ms": {"total": timing.total, "network": None if runtime is None else timing.network},
    }
    print(json.dumps(answer, indent=2, allow_nan=False))
    return 0
