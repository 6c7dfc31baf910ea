"""Compare selectors on maps, judged by the exact oracle: figures in `compare.json`, a report to read in `report.html`.

On every map, every selector is asked for all four legs at the same base poses, drawn by the seed. Without MAPS it runs
on one fresh built-in course per terrain family.
"""

import argparse
import os
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from footsel.cli.numbers import whole_number
from footsel.cli.options import (
    add_jobs,
    add_map_format,
    add_robot,
    add_seed,
    load_map,
    needing,
    output_folder,
)
from footsel.cli.select import SELECTORS
from footsel.errors import InputError

if TYPE_CHECKING:
    from footsel.comparison.maps import NamedMap

HELP = "oracle, network and baselines on maps, with a report"


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
    parser.add_argument(
        "--poses", type=whole_number(1), default=200, metavar="N", help="base poses per map (default: %(default)s)"
    )
    parser.add_argument("--out", type=output_folder, required=True, metavar="DIR", help="folder of the two files")
    parser.add_argument(
        "--model", type=Path, metavar="PATH", help="model folder of cnn (default: the robot's released one)"
    )
    add_robot(parser)
    add_seed(parser)
    add_jobs(parser)


def run(args: argparse.Namespace) -> int:
    """Compare, write both files and say where the report is."""
    _check_writable(args.out)
    with needing("footsel compare", "oracle"):
        import joblib

        from footsel.comparison.compare import compare
    # Imported first, so that a missing package shows before the work.
    from footsel.benchmark.machine import cpu_name
    from footsel.comparison.files import write_comparison
    from footsel.comparison.report import Run, render

    comparison = compare(_maps(args), args.selectors, args.robot, args.poses, args.seed, args.jobs, args.model)
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
    words += ["--selectors", *args.selectors, "--poses", str(args.poses), "--seed", str(args.seed)]
    words += ["--robot", args.robot, "--out", args.out.resolve().name]
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
