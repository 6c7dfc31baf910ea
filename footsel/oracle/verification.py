"""The fast oracle held against the brute-force reference, cell by cell.

`python -m footsel.oracle.verification [MAPS...] --out verify.json` does it on every course family and the given maps.
"""

import argparse
import json
from dataclasses import dataclass, field
from pathlib import Path
from zlib import crc32

import joblib
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from footsel.files import replace_file
from footsel.footholds import BasePose, Reason
from footsel.legs import LEGS
from footsel.oracle import Label, Oracle
from footsel.oracle.brute_force import BruteForceOracle
from footsel.terrain import ElevationMap, LocalMap
from footsel.terrain.courses import FAMILIES, make_course

#: Height of the base over the ground, as a share of the standing height.
HEIGHT_SHARE = (0.74, 1.23)

#: Roll and pitch of the base lie within this. [rad]
TILT = float(np.deg2rad(15.0))


@dataclass
class Comparison:
    """What was compared and what differed.

    cells, reasons: number of cells, in all and by the reference's reason. differing: a line for each that differs.
    terrain_cost_error: the largest. margin_errors: of the cells whose margin was compared, in [m].
    """

    cells: int = 0
    differing: list[str] = field(default_factory=list)
    terrain_cost_error: float = 0.0
    margin_errors: list[float] = field(default_factory=list)
    reasons: NDArray[np.int64] = field(default_factory=lambda: np.zeros(len(Reason), dtype=np.int64))


def draw_local_map(
    oracle: Oracle, elevation_map: ElevationMap, leg: str, rng: np.random.Generator
) -> tuple[LocalMap, float, float]:
    """A local map of `leg` with the base 0.74 to 1.23 standing heights above the ground (ANYmal B: 0.36 to 0.60 m).

    Returns the map, roll and pitch.
    """
    layout = oracle.robot.layout
    known = np.argwhere(elevation_map.known)
    while True:
        i, j = known[rng.integers(len(known))]
        x, y, yaw = elevation_map.x()[i], elevation_map.y()[j], rng.uniform(-np.pi, np.pi)
        ground = layout.ground_height(elevation_map, x, y, yaw)
        if not np.isnan(ground):
            break
    roll, pitch = rng.uniform(-TILT, TILT, 2)
    pose = BasePose(x, y, ground + rng.uniform(*HEIGHT_SHARE) * layout.standing_height, roll, pitch, yaw)
    return layout.local_map(elevation_map, pose, leg), roll, pitch


def compare(
    label: Label,
    reference: BruteForceOracle,
    local_map: LocalMap,
    tilt: tuple[float, float],
    cells: NDArray[np.intp],
    into: Comparison,
    margins: int = 0,
) -> None:
    """Compare the label with the reference on `cells` (k, 2), and margins until `into` holds `margins` of them."""
    for i, j in cells.tolist():
        feasible = bool(label.feasible[i, j])
        with_margin = feasible and len(into.margin_errors) < margins
        expected = reference.label_cell(local_map, *tilt, (i, j), with_margin=with_margin)
        into.cells += 1
        into.reasons[expected.reason] += 1
        found = Reason(int(label.reason[i, j]))
        if found != expected.reason:
            into.differing.append(f"cell {(i, j)}: {found.name}, the reference says {expected.reason.name}")
        elif found != Reason.UNKNOWN:
            error = abs(label.terrain_cost[i, j] - expected.terrain_cost)
            into.terrain_cost_error = max(into.terrain_cost_error, error)
            if with_margin:
                into.margin_errors.append(abs(label.kinematic_margin[i, j] - expected.margin))


def draw_cells(local_map: LocalMap, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Random cells (k, 2), known and unknown."""
    flat = rng.permutation(local_map.cells**2)[:count]
    return np.stack(np.unravel_index(flat, local_map.heights.shape), axis=-1)


def compare_source(
    source: str, leg: str, maps: int, cells_per_map: int, margins: int, oracle: Oracle | None = None
) -> Comparison:
    """Compare on `maps` random local maps of one leg on a course family, by name, or on a map file, by path."""
    oracle = oracle or Oracle.load()
    reference = BruteForceOracle(oracle.robot, leg)
    rng = np.random.default_rng(crc32(f"{Path(source).name} {leg}".encode()))
    comparison = Comparison()
    for _ in range(maps):
        elevation_map = (
            make_course(source, int(rng.integers(1000))) if source in FAMILIES else ElevationMap.load(source)
        )
        local_map, roll, pitch = draw_local_map(oracle, elevation_map, leg, rng)
        cells = draw_cells(local_map, cells_per_map, rng)
        label = oracle.label(local_map, leg, roll, pitch)
        compare(label, reference, local_map, (roll, pitch), cells, comparison, margins)
    return comparison


def main() -> int:
    """Compare on every course family and the given maps, four legs each; 1 if any reason differs."""
    parser = argparse.ArgumentParser(prog="python -m footsel.oracle.verification", description=__doc__)
    parser.add_argument("maps", nargs="*", metavar="MAP", help="elevation maps to compare on as well")
    parser.add_argument("--out", type=Path, help="write the figures to this JSON file")
    parser.add_argument("--maps-per-leg", type=int, default=6, help="local maps per source and leg (default 6)")
    parser.add_argument("--cells", type=int, default=110, help="cells per local map (default 110)")
    parser.add_argument("--margins", type=int, default=7, help="margins per source and leg (default 7)")
    parser.add_argument("--jobs", type=int, default=-1, help="processes (default: one per core)")
    options = parser.parse_args()

    work = [(source, leg) for source in (*FAMILIES, *options.maps) for leg in LEGS]
    parts = joblib.Parallel(n_jobs=options.jobs, return_as="generator")(
        joblib.delayed(compare_source)(source, leg, options.maps_per_leg, options.cells, options.margins)
        for source, leg in work
    )
    total = Comparison()
    for (source, leg), part in zip(work, tqdm(parts, total=len(work), desc="verify"), strict=True):
        for line in part.differing:
            print(f"{source} {leg}: {line}")
        total.cells += part.cells
        total.reasons += part.reasons
        total.differing += part.differing
        total.terrain_cost_error = max(total.terrain_cost_error, part.terrain_cost_error)
        total.margin_errors += part.margin_errors
    figures = {
        "sources": [Path(source).name for source in (*FAMILIES, *options.maps)],
        "cells": total.cells,
        "cells_by_reason": {reason.name: int(total.reasons[reason]) for reason in Reason},
        "differing_reasons": len(total.differing),
        "terrain_cost_error": total.terrain_cost_error,
        "margins": len(total.margin_errors),
        "margin_error": max(total.margin_errors, default=0.0),
        "margin_error_mean": float(np.mean(total.margin_errors)) if total.margin_errors else 0.0,
    }
    text = json.dumps(figures, indent=1) + "\n"
    print(text, end="")
    if options.out:
        replace_file(options.out, lambda path: path.write_text(text, encoding="utf-8"))
    return int(bool(total.differing))


if __name__ == "__main__":
    raise SystemExit(main())
