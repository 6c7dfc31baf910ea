"""Make a model folder of a training run: ONNX files, model card, metrics, parity report and checksums.

A released model is exported again with the contract of this version; its answers stay as they are.
"""

import argparse
from pathlib import Path

from footsel.cli.numbers import whole_number
from footsel.cli.options import needing, output_folder

HELP = "a training run as ONNX models that run on the robot"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of `footsel export`."""
    parser.add_argument("trained", metavar="RUN", type=Path, help="folder of `footsel train`, or a released model")
    parser.add_argument("out", metavar="OUT", type=output_folder, help="model folder")
    parser.add_argument("--int8", action="store_true", help="add a variant quantised to 8 bits")
    parser.add_argument(
        "--without-weights",
        action="store_true",
        help="leave out the .safetensors files, which runtimes do not need and trainings go on from",
    )
    parser.add_argument(
        "--parity-maps",
        type=whole_number(1),
        default=10_000,
        metavar="N",
        help="maps on which the files are compared with the trained network (default: %(default)s, some minutes)",
    )


def run(args: argparse.Namespace) -> int:
    """Export front and hind."""
    with needing("footsel export", "train"):
        from footsel.exporting.export_run import export_run

    out = export_run(args.trained, args.out, args.int8, args.parity_maps, weights=not args.without_weights)
    print(f"model: {out} (how near it is to the trained network: {out / 'parity.json'})")
    print(f"next: footsel select MAP --pose 0 0 auto 0 0 0 --model {out}")
    return 0
