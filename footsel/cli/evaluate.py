"""Judge trained or exported networks on a dataset that they were not trained on."""

import argparse
from pathlib import Path

from footsel.cli.numbers import share
from footsel.cli.options import add_seed, needing, output_file

HELP = "metrics of a checkpoint or an ONNX model on a dataset"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel evaluate`."""
    parser.add_argument(
        "model", metavar="MODEL", type=Path, help="run of `footsel train`, one pair of it, model folder or .onnx file"
    )
    parser.add_argument("dataset", metavar="DATASET", type=Path, help="folder of `footsel dataset`")
    parser.add_argument("--out", type=output_file, required=True, metavar="M.json", help="the metrics")
    parser.add_argument("--families", nargs="+", metavar="FAMILY", help="judge maps of these terrain families alone")
    parser.add_argument("--exclude", nargs="+", metavar="FAMILY", help="leave maps of these families out")
    parser.add_argument(
        "--noise",
        default="none",
        metavar="NAME",
        help="none or d435: heights as one image of that depth camera sees them",
    )
    parser.add_argument(
        "--holes",
        type=share,
        default=0.0,
        metavar="SHARE",
        help="share of each map's cells that the network is not shown, 0 to 1; labels stay those of the true map",
    )
    parser.add_argument(
        "--plot", type=output_file, metavar="P.png", help="also draw reliability, thresholds, confusion"
    )
    add_seed(parser)


def run(args: argparse.Namespace) -> int:
    """Write the metrics and print the main ones."""
    with needing("footsel evaluate", "train"):
        from footsel.learning.degraded import Degradation
        from footsel.learning.evaluate import evaluate_model

    degradation = Degradation(args.noise, args.holes, args.seed)
    if args.plot:
        with needing("--plot", "report"):
            from footsel.comparison.judgement_sheet import draw_judgement_sheet
    asked = None if degradation == Degradation(seed=args.seed) else degradation
    result = evaluate_model(args.model, args.dataset, args.out, args.families, args.exclude, asked)
    if args.plot:
        draw_judgement_sheet(args.plot, result)
    for name, figures in result["networks"].items():
        overall = figures["all"]
        parts = {
            "accuracy": overall["cells"]["accuracy"],
            "mIoU": overall["cells"]["miou_present"],
            "false safe": overall["cells"]["false_safe_rate"],
            "infeasible picks": overall["picks"]["infeasible_rate"],
            "missed": overall["picks"]["missed_rate"],
            "regret": overall["picks"]["regret_mean"],
        }
        shown = ", ".join(f"{key} {'-' if value is None else format(value, '.3g')}" for key, value in parts.items())
        print(f"{name}: {shown}")
    print(f"metrics: {args.out}")
    return 0
