"""Compare selectors and write a report to read, `report.html`.

On MAPS, judged by the exact oracle: every selector is asked for all four legs at the same base poses, drawn by the
seed; figures in `compare.json`. Without MAPS it runs on one fresh built-in course per terrain family.

With --walk, in physics: ANYmal walks over the same courses with every selector; figures in `walks.json`. The same
command goes on where an interrupted one stopped, and finished walks are never repeated.
"""

import argparse
import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from footsel.cli.numbers import whole_number
from footsel.cli.options import (
    add_engine,
    add_jobs,
    add_map_format,
    add_robot,
    add_seed,
    check_engine,
    load_map,
    map_options,
    needing,
    output_folder,
)
from footsel.cli.select import SELECTORS
from footsel.cli.walk import MAPS, TERRAINS, add_limbs
from footsel.errors import InputError

if TYPE_CHECKING:
    from footsel.comparison.maps import NamedMap

HELP = "oracle, network and baselines on maps or in walks, with a report"

POSES, SEEDS, MAP = 200, 10, "exact"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel compare`."""
    parser.add_argument(
        "maps",
        metavar="MAPS",
        nargs="*",
        type=Path,
        help="elevation maps: .npz, .png, ROS bags with a GridMap, .pcd or .ply (default: built-in courses)",
    )
    add_map_format(parser)
    parser.add_argument(
        "--selectors",
        nargs="+",
        default=("oracle", "cnn", "nominal"),
        metavar="NAME",
        help=f"among {', '.join(SELECTORS)} (default: oracle cnn nominal)",
    )
    parser.add_argument("--poses", type=whole_number(1), metavar="N", help=f"base poses per map (default: {POSES})")
    walking = parser.add_argument_group("walks")
    walking.add_argument(
        "--walk",
        nargs="+",
        metavar="TERRAIN",
        help=f"walk instead, over terrains among {', '.join(TERRAINS)}, or across maps that files hold",
    )
    walking.add_argument(
        "--seeds",
        type=whole_number(1),
        metavar="N",
        help=f"courses per terrain, of the seeds from --seed on (default: {SEEDS})",
    )
    walking.add_argument(
        "--map", choices=MAPS, help=f"what the robot knows of the ground: {', '.join(MAPS)} (default: {MAP})"
    )
    add_limbs(walking)
    add_engine(walking)
    parser.add_argument("--out", type=output_folder, required=True, metavar="DIR", help="folder of the two files")
    parser.add_argument(
        "--model", type=Path, metavar="PATH", help="model folder of cnn (default: the robot's released one)"
    )
    add_robot(parser)
    add_seed(parser)
    add_jobs(parser)


def run(args: argparse.Namespace) -> int:
    """Compare, write both files and say where the report is."""
    if args.walk is None:
        for option, value in (("--seeds", args.seeds), ("--map", args.map), ("--scheduler", args.scheduler)):
            if value is not None:
                raise InputError(f"{option} is about walks", "give --walk TERRAIN too, or leave it out")
        if not args.limb_watch:
            raise InputError("--no-limb-watch is about walks", "give --walk TERRAIN too, or leave it out")
    elif args.maps or args.poses is not None:
        given = "MAPS" if args.maps else "--poses"
        raise InputError(
            f"{given} and --walk exclude each other", "compare on maps or in walks; --walk takes map files too"
        )
    check_engine(args)
    _check_writable(args.out)
    return _compare_on_maps(args) if args.walk is None else _compare_walks(args)


def _compare_on_maps(args: argparse.Namespace) -> int:
    with needing("footsel compare", "oracle"):
        import joblib

        from footsel.comparison.compare import compare
    # Imported first, so that a missing package shows before the work.
    from footsel.benchmark.machine import cpu_name
    from footsel.comparison.files import write_comparison
    from footsel.comparison.report import Run, render

    poses = args.poses or POSES
    comparison = compare(_maps(args), args.selectors, args.robot, poses, args.seed, args.jobs, args.model)
    figures = comparison.figures()
    used = Run(_command(args), joblib.effective_n_jobs(args.jobs), cpu_name())
    report = write_comparison(args.out, {**figures, "run": used.to_dict()}, render(comparison, figures, used))
    for name, picks in figures["selectors"].items():
        rate = "-" if picks["infeasible_rate"] is None else f"{picks['infeasible_rate']:.2%}"
        regret = "-" if picks["regret_mean"] is None else f"{picks['regret_mean']:.1f}"
        print(
            f"{name:14} {picks['picks']:7} picks  {rate:>7} infeasible  {picks['missed']:5} missed  regret {regret:>5}"
        )
    print(f"report: {report}")
    return 0


def _compare_walks(args: argparse.Namespace) -> int:
    with needing("footsel compare --walk", "sim"):
        import joblib

        from footsel.comparison.walks.compare import compare_walks
    from footsel.benchmark.machine import cpu_name
    from footsel.comparison.files import WALKS_FILE, write_comparison
    from footsel.comparison.report import LIBRARIES, Run
    from footsel.comparison.walks.report import render

    comparison = compare_walks(
        args.walk,
        args.selectors,
        args.out,
        args.seeds or SEEDS,
        args.seed,
        args.map or MAP,
        args.robot,
        args.model,
        map_options(args),
        args.jobs,
        args.scheduler,
        args.limb_watch,
    )
    figures = comparison.figures()
    used = Run(_command(args), joblib.effective_n_jobs(args.jobs), cpu_name(), (*LIBRARIES, "pybullet"))
    page = render(comparison.walks, comparison.drawn_courses(), figures, used)
    report = write_comparison(args.out, {**figures, "run": used.to_dict()}, page, WALKS_FILE)
    for terrain, selectors in figures["summary"].items():
        for name, part in selectors.items():
            low, high = part["ci95"]
            print(f"{terrain:14} {name:14} {part['success_rate']:6.1%} of {part['n']} walks  ({low:.1%} to {high:.1%})")
    print(f"report: {report}")
    return 0


def _maps(args: argparse.Namespace) -> "list[NamedMap]":
    from footsel.comparison.maps import NamedMap, built_in_courses

    if not args.maps:
        return built_in_courses(args.seed)
    return [NamedMap(str(path), load_map(args, path)) for path in args.maps]


def _check_writable(out: Path) -> None:
    """Raise InputError if `out` cannot be made, before minutes of work are lost."""
    out = out.resolve()
    there = next(folder for folder in (out, *out.parents) if folder.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        raise InputError(f"--out {out}: {there} is no folder to write to", "give another place")


def _command(args: argparse.Namespace) -> str:
    """The command that makes the same figures, whatever the folder; where that lies is nobody else's business."""
    words = ["footsel", "compare", *(str(path) for path in args.maps)]
    if args.walk is not None:
        words += ["--walk", *args.walk, "--seeds", str(args.seeds or SEEDS), "--map", args.map or MAP]
    if not args.limb_watch:
        words.append("--no-limb-watch")
    words += ["--selectors", *args.selectors]
    if args.walk is None:
        words += ["--poses", str(args.poses or POSES)]
    words += ["--seed", str(args.seed), "--robot", args.robot, "--out", args.out.resolve().name]
    if args.model is not None:
        words += ["--model", str(args.model)]
    if args.resolution is not None:
        words += ["--resolution", str(args.resolution)]
    if args.png_range is not None:
        words += ["--png-range", *(str(height) for height in args.png_range)]
    if args.png_zero_unknown:
        words.append("--png-zero-unknown")
    if args.layer != "elevation":
        words += ["--layer", args.layer]
    return shlex.join(words)
