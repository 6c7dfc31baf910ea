"""Let ANYmal walk over a course in PyBullet with one selector, and print what came of it as JSON.

The exit code is 0 whenever the walk took place; whether it reached the goal stands in the JSON.
"""

import argparse
import json
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from footsel.cli.options import add_map_format, add_robot, add_seed, map_options, needing, output_file
from footsel.cli.select import SELECTORS
from footsel.errors import InputError

if TYPE_CHECKING:
    from footsel.walking.observer import WalkObserver

HELP = "one walk in physics, as JSON and on film"

#: The names of footsel.walking, which loads too much to show help.
TERRAINS = (
    "flat",
    "slopes",
    "stairs12",
    "stairs",
    "stairs17",
    "rough",
    "blocks",
    "rubble",
    "stones",
    "stones_hard",
    "gaps",
)
MAPS = ("exact", "noisy", "camera")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel walk`."""
    parser.add_argument(
        "--terrain",
        required=True,
        metavar="NAME|MAP",
        help=f"{', '.join(TERRAINS)}, or an elevation map's file, crossed from side to side",
    )
    add_map_format(parser)
    parser.add_argument(
        "--selector", default="cnn", metavar="NAME", help=f"{', '.join(SELECTORS)} (default: %(default)s)"
    )
    parser.add_argument(
        "--map",
        choices=MAPS,
        default="exact",
        help="what the robot knows of the ground: all, as one depth camera's readings leave it, or what its cameras "
        "see on the way (default: %(default)s)",
    )
    add_limbs(parser)
    parser.add_argument(
        "--model", type=Path, metavar="PATH", help="model folder of cnn (default: the robot's released one)"
    )
    parser.add_argument(
        "--video", type=output_file, metavar="W.mp4", help="also film the walk, at four times its speed"
    )
    parser.add_argument("--picture", type=output_file, metavar="P.png", help="also draw the robot half way")
    add_robot(parser)
    add_seed(parser)


def add_limbs(parser: argparse._ActionsContainer) -> None:
    """--no-limb-watch, as args.limb_watch."""
    parser.add_argument(
        "--no-limb-watch",
        dest="limb_watch",
        action="store_false",
        help="the planner does not keep thighs and shanks clear of the ground: only the choice of footholds does",
    )


def run(args: argparse.Namespace) -> int:
    """Walk and print the result."""
    for option, path, suffix in (("--video", args.video, ".mp4"), ("--picture", args.picture, ".png")):
        if path is not None and path.suffix.lower() != suffix:
            raise InputError(f"{option} {path} is no {suffix} file", f"give a name that ends in {suffix}")
    with needing("footsel walk", "sim"):
        import footsel.walking.bullet  # noqa: F401 - it names the extra that brings all the others
        from footsel.robot import load_robot
        from footsel.selectors import make_selector
        from footsel.walking.runs.job import WalkJob
        from footsel.walking.runs.one import run_job
        from footsel.walking.runs.progress import Progress

    job = WalkJob(
        args.terrain,
        args.selector,
        args.seed,
        args.map,
        args.robot,
        args.model,
        map_options(args),
        watch_limbs=args.limb_watch,
    )
    course = job.course()
    selector = make_selector(job.selector, job.robot, job.model)
    with ExitStack() as stack:
        observers: list[WalkObserver] = [stack.enter_context(Progress(course))]
        if args.video or args.picture:
            with needing("--video and --picture", "report"):
                from footsel.comparison.walks.film import Film, Still
            robot = load_robot(job.robot)
            if args.video:
                observers.append(stack.enter_context(Film(args.video, course, robot, selector)))
            if args.picture:
                observers.append(Still(args.picture, course, robot, selector))
        result = run_job(job, selector, observers, course)
    print("reached the goal" if result.success else f"failed: {result.reason}", file=sys.stderr)
    print(json.dumps(result.to_dict(), indent=2, allow_nan=False))
    return 0
