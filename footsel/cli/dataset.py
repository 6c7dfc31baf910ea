"""Make a dataset of labelled local maps on generated terrain.

The same command goes on where an interrupted one stopped. The result depends on the seed, never on the number of jobs.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from footsel.cli.numbers import whole_number
from footsel.cli.options import add_jobs, add_pairs, add_robot, add_seed, needing, output_folder
from footsel.errors import InputError
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
        "tilt up to 15 degrees, holes (default: %(default)s)",
    )
    parser.add_argument("--families", nargs="+", default=(), metavar="FAMILY", help="terrain families to draw from")
    parser.add_argument("--exclude", nargs="+", default=(), metavar="FAMILY", help="terrain families to leave out")
    parser.add_argument("--engine", choices=("local", "dask"), default="local", help="where the jobs run")
    parser.add_argument("--scheduler", metavar="ADDR", help="address of the Dask scheduler, such as tcp://host:8786")
    add_robot(parser)
    add_seed(parser)
    add_jobs(parser)


def run(args: argparse.Namespace) -> int:
    """Make the shards and the manifest."""
    if (args.engine == "dask") != (args.scheduler is not None):
        raise InputError("--engine dask and --scheduler ADDR belong together", "give both or neither")
    with needing("footsel dataset", "oracle"):
        from footsel.dataset import open_dataset
        from footsel.dataset.generate import DatasetConfig, generate

    config = DatasetConfig(
        robot=args.robot,
        pairs=tuple(pair for pair in PAIRS if pair in args.legs),
        maps=args.maps,
        seed=args.seed,
        recipe=args.recipe,
        families=tuple(args.families),
        exclude=tuple(args.exclude),
    )
    with _engine(args.engine, args.scheduler):
        manifest = generate(config, args.out, args.jobs)
    dataset = open_dataset(args.out)
    for pair in dataset.pairs:
        entry = dataset.manifest["pairs"][pair]
        shares = {name.lower().replace("_", " "): share for name, share in entry["reason_shares"].items()}
        unknown = shares.pop("unknown")
        known = ", ".join(f"{share:.1%} {name}" for name, share in shares.items())
        print(f"{pair}: {entry['samples']} maps, {unknown:.1%} of their cells unknown; of the others {known}")
    print(f"manifest: {manifest}")
    print(f"next: footsel train {args.out} RUN --recipe {args.recipe}")
    return 0


@contextmanager
def _engine(name: str, scheduler: str | None) -> Iterator[None]:
    """joblib's local backend, or the Dask cluster of a scheduler."""
    if name == "local":
        yield
        return
    with needing("--engine dask", "cluster"):
        from distributed import Client
    from joblib import parallel_config

    try:
        client = Client(scheduler, timeout=10)
    except (OSError, ValueError) as error:
        raise InputError(
            f"no Dask scheduler answers at {scheduler} ({error})", "start one with `dask scheduler`"
        ) from None
    with client, parallel_config("dask"):
        yield
