"""Make a dataset of labelled local maps on generated terrain.

The same command goes on where an interrupted one stopped. The result depends on the seed, never on the number of jobs
or on where they run.
"""

import argparse
import sys
import time
from collections.abc import Mapping
from typing import Any

from footsel.cli.numbers import whole_number
from footsel.cli.options import (
    add_engine,
    add_jobs,
    add_pairs,
    add_robot,
    add_seed,
    check_engine,
    needing,
    output_folder,
)
from footsel.legs import PAIRS

HELP = "labelled pairs of local map and cost"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel dataset`."""
    parser.add_argument("out", metavar="OUT", type=output_folder, help="folder, new or of the same command")
    add_pairs(parser, PAIRS, "both")
    parser.add_argument(
        "--maps", type=whole_number(1), default=20000, help="local maps per pair of legs (default: %(default)s)"
    )
    parser.add_argument(
        "--recipe",
        default="footsel",
        help="paper: one composed map, four headings, level base; footsel: courses of all families, any heading, "
        "tilt up to 15 degrees, holes; four_headings: as footsel, but for the paper's headings (default: %(default)s)",
    )
    parser.add_argument(
        "--families", nargs="+", default=(), metavar="FAMILY", help="terrain families to draw from (default: all)"
    )
    parser.add_argument(
        "--exclude",
        nargs="+",
        default=(),
        metavar="FAMILY",
        help="terrain families to leave out, such as those that a network shall be judged on unseen",
    )
    parser.add_argument(
        "--maps-per-shard", type=whole_number(1), default=250, metavar="N", help="in one file (default: %(default)s)"
    )
    add_engine(parser)
    add_robot(parser)
    add_seed(parser)
    add_jobs(parser)


def run(args: argparse.Namespace) -> int:
    """Make the shards and the manifest."""
    check_engine(args)
    with needing("footsel dataset", "oracle"):
        from footsel.dataset import open_dataset
        from footsel.dataset.config import DatasetConfig
        from footsel.dataset.generate import generate

    config = DatasetConfig(
        robot=args.robot,
        pairs=tuple(pair for pair in PAIRS if pair in args.legs),
        maps=args.maps,
        seed=args.seed,
        recipe=args.recipe,
        families=tuple(args.families),
        exclude=tuple(args.exclude),
        maps_per_shard=args.maps_per_shard,
    )
    began = time.monotonic()
    path = generate(config, args.out, args.jobs, args.scheduler)
    print(f"finished after {time.monotonic() - began:.0f} s", file=sys.stderr)
    manifest = open_dataset(args.out).manifest
    for name, entry in (*manifest["pairs"].items(), ("all", manifest)):
        print(f"{name}: {entry['samples']} maps; {_in_words(entry)}")
    print(f"manifest: {path}")
    print(f"next: footsel train {args.out} RUN --recipe {'paper' if args.recipe == 'paper' else 'footsel'}")
    return 0


def _in_words(entry: Mapping[str, Any]) -> str:
    """What decides the cells."""
    known = ", ".join(f"{share:.1%} {_spelt(name)}" for name, share in entry["reason_shares"].items())
    return f"{entry['unknown_share']:.1%} of their cells unknown, of the known ones {known}"


def _spelt(name: str) -> str:
    return name.lower().replace("_", " ")
