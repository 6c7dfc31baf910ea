"""Options that several commands share, and what they stand for."""

import argparse
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from footsel.cli.numbers import finite_number, jobs, whole_number
from footsel.errors import InputError, MissingExtraError, UnknownNameError
from footsel.footholds import BasePose, LegLayout
from footsel.legs import LEGS, PAIRS, check_leg, check_pair
from footsel.terrain import ElevationMap

POSE_NAMES = ("X", "Y", "Z", "ROLL", "PITCH", "YAW")

#: Poses are on maps of metres; a number beyond this is a slip, and would not fit the heights' 32-bit floats.
FARTHEST = 1e6


def add_map(parser: argparse.ArgumentParser) -> None:
    """The positional MAP and how it is read."""
    parser.add_argument(
        "map", metavar="MAP", type=Path, help="elevation map: .npz, .png, a ROS bag with a GridMap, .pcd or .ply"
    )
    add_map_format(parser)


def add_map_format(parser: argparse.ArgumentParser) -> None:
    """What some map formats do not say themselves."""
    group = parser.add_argument_group("map formats")
    group.add_argument(
        "--resolution",
        type=finite_number,
        metavar="R",
        help="side of a cell of an image, or of the grid for a point cloud [m]",
    )
    group.add_argument(
        "--png-range", type=finite_number, nargs=2, metavar=("LOW", "HIGH"), help="heights of black and white [m]"
    )
    group.add_argument("--png-zero-unknown", action="store_true", help="black pixels of an image are unknown")
    group.add_argument("--layer", default="elevation", help="layer of a GridMap (default: %(default)s)")


def map_options(args: argparse.Namespace) -> dict[str, Any]:
    """How the options say that a map file is read: the keywords of ElevationMap.load."""
    return {
        "resolution": args.resolution,
        "png_range": args.png_range,
        "png_zero_unknown": args.png_zero_unknown,
        "layer": args.layer,
    }


def load_map(args: argparse.Namespace, path: Path | None = None) -> ElevationMap:
    """The map at `path` (default: MAP), read as the options say."""
    return ElevationMap.load(args.map if path is None else path, **map_options(args))


def add_robot(parser: argparse.ArgumentParser) -> None:
    """--robot."""
    parser.add_argument(
        "--robot", type=_robot, default="anymal_b", help="a name of `footsel robots` (default: %(default)s)"
    )


def add_legs(parser: argparse.ArgumentParser) -> None:
    """--legs of those that choose footholds."""
    parser.add_argument(
        "--legs", nargs="+", type=check_leg, default=LEGS, metavar="LEG", help=f"among {' '.join(LEGS)} (default: all)"
    )


def add_pairs(parser: argparse.ArgumentParser, default: Sequence[str] | None, default_help: str) -> None:
    """--legs of those that train networks, one for each pair of legs."""
    parser.add_argument(
        "--legs",
        nargs="+",
        type=check_pair,
        default=default,
        metavar="PAIR",
        help=f"pairs of legs among {' '.join(PAIRS)} (default: {default_help})",
    )


def add_seed(parser: argparse.ArgumentParser) -> None:
    """--seed."""
    parser.add_argument(
        "--seed", type=whole_number(0), default=0, help="of everything that is random (default: %(default)s)"
    )


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """--jobs; results never depend on it."""
    parser.add_argument(
        "--jobs", type=jobs, default=-1, metavar="N", help="processes; -1 is one per core (default: %(default)s)"
    )


def add_engine(parser: argparse._ActionsContainer) -> None:
    """--engine and --scheduler: where independent jobs run."""
    parser.add_argument(
        "--engine",
        choices=("local", "dask"),
        default="local",
        help="where the jobs run: processes on this machine, or the workers of a Dask cluster (default: %(default)s)",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDR",
        help="address of the Dask scheduler, such as tcp://host:8786; its workers need the same extras of footsel and "
        "cluster, and no common disk",
    )


def check_engine(args: argparse.Namespace) -> None:
    """Raise InputError if only one of --engine dask and --scheduler is given."""
    if (args.engine == "dask") != (args.scheduler is not None):
        raise InputError("--engine dask and --scheduler ADDR belong together", "give both or neither")


@dataclass(frozen=True)
class PoseArgument:
    """What stands after --pose; z is None for `auto`."""

    x: float
    y: float
    z: float | None
    roll: float
    pitch: float
    yaw: float

    def on(self, elevation_map: ElevationMap, layout: LegLayout) -> BasePose:
        """The base's pose; `auto` is the nominal standing height above the median ground under the nominal feet.

        Raises InputError for a base off the map, and for `auto` where no ground is known.
        """
        level = BasePose(self.x, self.y, 0.0 if self.z is None else self.z, self.roll, self.pitch, self.yaw)
        layout.check_on_map(elevation_map, level)
        if self.z is not None:
            return level
        ground = layout.ground_height(elevation_map, self.x, self.y, self.yaw)
        if math.isnan(ground):
            raise InputError(
                f"Z is auto, but no ground is known under the feet at x={self.x:g} y={self.y:g}",
                "give Z in metres or another place",
            )
        return BasePose(self.x, self.y, ground + layout.standing_height, self.roll, self.pitch, self.yaw)


class _PoseAction(argparse.Action):
    """Six words to a PoseArgument."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,  # noqa: ARG002 - part of argparse's signature
        namespace: argparse.Namespace,
        values: Any,
        option: str | None = None,
    ) -> None:
        numbers: list[Any] = []
        for name, word in zip(POSE_NAMES, values, strict=True):
            if name == "Z" and word.strip() == "auto":
                numbers.append(None)
                continue
            try:
                numbers.append(finite_number(word))
            except InputError as error:
                raise InputError(f"{name} of {option}: {error.what}", error.remedy) from None
            if abs(numbers[-1]) > FARTHEST:
                raise InputError(f"{name} of {option} is {word.strip()}", "give metres and radians")
        setattr(namespace, self.dest, PoseArgument(*numbers))


def add_pose(parser: argparse.ArgumentParser) -> None:
    """--pose, required."""
    parser.add_argument(
        "--pose",
        action=_PoseAction,
        nargs=len(POSE_NAMES),
        metavar=POSE_NAMES,
        required=True,
        help="base in the world frame [m, rad]; Z may be `auto`: standing height above the ground under the feet",
    )


def output_file(text: str) -> Path:
    """A file that can be written: its folder exists. Raises InputError otherwise."""
    path = Path(text)
    if path.is_dir():
        raise InputError(f"{path} is a folder", "give a file name")
    if not path.parent.is_dir():
        raise InputError(f"{path.parent} is no folder", "make it first, or give another place")
    return path


def output_folder(text: str) -> Path:
    """A folder to write into, which need not exist yet. Raises InputError if it is a file."""
    path = Path(text)
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} is a file", "give a folder")
    return path


@contextmanager
def needing(feature: str, extra: str) -> Iterator[None]:
    """Around late imports: a package that is not installed becomes a MissingExtraError."""
    try:
        yield
    except ModuleNotFoundError as error:
        if (error.name or "footsel").startswith("footsel"):
            raise
        raise MissingExtraError(feature, extra, str(error.name)) from None


def _robot(name: str) -> str:
    from footsel.robot import robot_names

    if name not in robot_names():
        raise UnknownNameError("robot", name, robot_names())
    return name
