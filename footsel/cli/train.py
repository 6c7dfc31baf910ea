"""Train the networks of a dataset: a checkpoint, the model and its learning curves for each pair of legs.

Under torchrun all its processes train one network together, pair after pair.
"""

import argparse
import os
from functools import partial
from pathlib import Path

from footsel.cli.numbers import positive_number, whole_number
from footsel.cli.options import add_jobs, add_pairs, add_seed, needing, output_folder

HELP = "networks from a dataset"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel train`."""
    parser.add_argument("dataset", metavar="DATASET", type=Path, help="folder of `footsel dataset`")
    parser.add_argument("out", metavar="OUT", type=output_folder, help="folder of the run")
    parser.add_argument(
        "--recipe", default="footsel", help="paper, footsel or a TOML file like theirs (default: %(default)s)"
    )
    add_pairs(parser, None, "those of the dataset")
    parser.add_argument("--resume", action="store_true", help="go on with the training that OUT holds")
    parser.add_argument("--epochs", type=whole_number(1), metavar="N", help="instead of the recipe's")
    parser.add_argument("--learning-rate", type=positive_number, metavar="R", help="instead of the recipe's")
    parser.add_argument(
        "--from",
        dest="start",
        metavar="MODEL",
        help="begin with the weights of this run, released model or .safetensors file (default: at random)",
    )
    parser.add_argument(
        "--exclude",
        nargs="+",
        default=(),
        metavar="FAMILY",
        help="terrain families to leave out, to judge the network on what it never saw (footsel evaluate --families)",
    )
    parser.add_argument(
        "--threads", type=whole_number(1), default=1, metavar="N", help="CPU threads of each (default: %(default)s)"
    )
    add_jobs(parser)
    add_seed(parser)


def run(args: argparse.Namespace) -> int:
    """Train all pairs, side by side if there are cores for it."""
    with needing("footsel train", "train"):
        from footsel.dataset import open_dataset
        from footsel.learning.ranks import ranks_of_torchrun
        from footsel.learning.recipe import Recipe
        from footsel.learning.side_by_side import in_turn, side_by_side
        from footsel.learning.train import train

    recipe = Recipe.load(args.recipe)
    dataset = open_dataset(args.dataset)
    pairs = args.legs or dataset.pairs
    for pair in pairs:
        dataset.shard_count(pair)  # Raises for a pair that the dataset lacks, before hours go into another one.
    train_pair = partial(
        train,
        args.dataset,
        args.out,
        recipe=recipe,
        resume=args.resume,
        epochs=args.epochs,
        seed=args.seed,
        threads=args.threads,
        learning_rate=args.learning_rate,
        start=args.start,
        exclude=tuple(args.exclude),
    )
    processes = args.jobs if args.jobs > 0 else (os.cpu_count() or 1)
    with ranks_of_torchrun() as ranks:
        if ranks.count > 1:
            trained = in_turn(partial(train_pair, ranks=ranks), pairs)
        else:
            trained = side_by_side(train_pair, pairs) if min(processes, len(pairs)) > 1 else in_turn(train_pair, pairs)
        for pair, info in trained:
            cells = info["validation"]["cells_likeliest"]
            done = f"{info['epochs_done']} epochs, validation accuracy {cells['accuracy']:.3f}"
            if ranks.first:
                print(f"{pair}: {done}, {args.out / pair}")
    if ranks.first:
        print(f"next: footsel export {args.out} MODEL")
    return 0
