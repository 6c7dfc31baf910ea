"""Measure the latency of every stage and every model variant on this machine, on one thread held to one core."""

import argparse
import json
import shutil
from pathlib import Path

from footsel.cli.numbers import whole_number
from footsel.cli.options import add_robot, add_seed, needing, output_file
from footsel.errors import InputError
from footsel.files import replace_file

HELP = "latency of the oracle and of every model variant on this machine"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel bench`."""
    parser.add_argument("--out", type=output_file, metavar="B.json", help="the figures, times in ms")
    parser.add_argument("--model", metavar="PATH", help="model folder (default: the robot's released one)")
    parser.add_argument(
        "--run", type=Path, metavar="RUN", help="of `footsel train`, or a released model: measure torch too"
    )
    parser.add_argument(
        "--calls",
        type=whole_number(1),
        default=2000,
        metavar="N",
        help="selections of each kind; p99.9 needs a thousand (default: %(default)s)",
    )
    parser.add_argument(
        "--maps", type=whole_number(1), default=440, metavar="N", help="maps for the oracle (default: %(default)s)"
    )
    parser.add_argument(
        "--histogram",
        type=whole_number(1),
        metavar="N",
        help="spread of N selections of each kind, with the other core idle and busy; 100000 take a quarter of an "
        "hour, and with --out a run that was ended goes on from B.json.parts",
    )
    parser.add_argument(
        "--cpp", type=Path, metavar="PROGRAM", help="the C++ library's footsel_bench (default: what `make cpp` builds)"
    )
    parser.add_argument("--plot", type=output_file, metavar="P.png", help="draw the histogram")
    add_robot(parser)
    add_seed(parser)


def run(args: argparse.Namespace) -> int:
    """Print a table and write the figures."""
    from footsel.benchmark import BenchmarkSize, as_table, draw_histogram, run_benchmark
    from footsel.benchmark.cpp import PROGRAM
    from footsel.runtime.model_folder import find_model_folder

    if args.plot and not args.histogram:
        raise InputError("--plot draws the histogram", "give --histogram N too")
    if args.plot:
        with needing("--plot", "report"):
            import matplotlib  # noqa: F401
    model = find_model_folder(args.model or args.robot)
    size = BenchmarkSize(calls=args.calls, maps=args.maps, histogram_calls=args.histogram or 0)
    parts = args.out.with_name(f"{args.out.name}.parts") if args.out and args.histogram else None
    figures = run_benchmark(args.robot, model, args.run, size, args.seed, args.cpp or PROGRAM, parts)
    if args.out:
        text = json.dumps(figures, indent=2, allow_nan=False) + "\n"
        replace_file(args.out, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    if parts:
        shutil.rmtree(parts)
    if args.plot:
        draw_histogram(figures["histogram"], args.plot)
    print(as_table(figures))
    return 0
