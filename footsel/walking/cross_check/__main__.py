"""Run one of the two checks on every course family and the given maps, four legs each.

contacts: PyBullet, with its own URDF parser, kinematics and contacts, on the primitives that the oracle uses. It fails
if an answer differs further than 5 mm from touching. meshes: coal, on the full meshes that the URDF shows; what differs
is counted, not judged.
"""

import argparse
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import joblib
import numpy as np
from tqdm import tqdm

from footsel.files import replace_file
from footsel.legs import LEGS
from footsel.oracle import Oracle
from footsel.terrain.courses import FAMILIES
from footsel.walking.cross_check.agreement import KINDS, Agreement, Check, check_source

#: Two engines may differ this near to touching. [m]
TOLERANCE = 0.005

#: Disagreements in the figures.
LISTED = 10


def main(argv: Sequence[str] | None = None) -> int:
    """Check, print a table, write the figures; 1 if PyBullet differs too far from touching."""
    options = _parser().parse_args(argv)
    sources = (*(options.families or FAMILIES), *options.maps)
    work = [(source, leg) for source in sources for leg in LEGS]
    Oracle.load()
    parts = joblib.Parallel(n_jobs=options.jobs, return_as="generator")(
        joblib.delayed(check_source)(source, leg, options.check, options.cells, options.cells_per_place, options.seed)
        for source, leg in work
    )
    done = dict(zip(work, tqdm(parts, total=len(work), desc=options.check, unit="part"), strict=True))
    figures = summary(options.check, done)
    print(table(figures))
    if options.out:
        text = json.dumps(figures, indent=1) + "\n"
        replace_file(options.out, lambda path: path.write_text(text, encoding="utf-8"))
    return int(not figures["passed"])


def summary(check: Check, parts: Mapping[tuple[str, str], Agreement]) -> dict[str, Any]:
    """The figures of all parts, by (source, leg)."""
    total = Agreement.sum(parts.values())
    distances = np.sort([each.distance for each in total.disagreements])
    bodies = Counter(
        (each.kind, "oracle" if each.oracle else "other", each.bodies[0] if each.bodies else "none")
        for each in total.disagreements
    )
    return {
        "check": check,
        "passed": check == "meshes" or bool((distances <= TOLERANCE).all()),
        **total.figures(),
        "distances": {
            name: float(distances[round(share * (len(distances) - 1))]) if len(distances) else 0.0
            for name, share in (("median", 0.5), ("p95", 0.95), ("max", 1.0))
        },
        "by_bodies": [
            {"kind": kind, "seen_by": seen, "bodies": pair, "cells": count}
            for (kind, seen, pair), count in bodies.most_common()
        ],
        "by_source": {
            Path(source).name: Agreement.sum(part for (name, _), part in parts.items() if name == source).figures()
            for source in dict.fromkeys(source for source, _ in parts)
        },
        "worst": total.worst(LISTED),
    }


def table(figures: Mapping[str, Any]) -> str:
    """A line per source and one for all."""
    head = f"{'cells in kinematic range':34}{'cells':>8}" + "".join(
        f"{f'{kind}: both':>14}{'oracle only':>13}{'other only':>12}" for kind in KINDS
    )
    lines = [head + f"{'largest distance':>19}"]
    for name, row in (*figures["by_source"].items(), ("all", figures)):
        kinds = "".join(
            f"{row[kind]['both']:14}{row[kind]['oracle_only']:13}{row[kind]['other_only']:12}" for kind in KINDS
        )
        lines.append(f"{name:34}{row['cells']:8}{kinds}{1e3 * row['largest_distance']:16.1f} mm")
    lines += ["", "furthest from touching:"]
    for each in figures["worst"]:
        seen = "the oracle" if each["oracle"] else "the other"
        lines.append(f"{1e3 * each['distance']:6.1f} mm, {seen} sees {', '.join(each['bodies'])}: {each['where']}")
    return "\n".join([*lines, "passed" if figures["passed"] else "FAILED"])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m footsel.walking.cross_check", description=__doc__)
    parser.add_argument("check", choices=("contacts", "meshes"), help="PyBullet's contacts, or the robot's full meshes")
    parser.add_argument("maps", nargs="*", metavar="MAP", help="elevation maps to check on as well")
    parser.add_argument("--families", nargs="+", choices=tuple(FAMILIES), help="course families (default: all)")
    parser.add_argument("--out", type=Path, help="write the figures to this JSON file")
    parser.add_argument(
        "--cells", type=int, default=1000, help="cells in kinematic range per source and leg (default %(default)s)"
    )
    parser.add_argument("--cells-per-place", type=int, default=150, help="at most, per local map (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of all that is random (default %(default)s)")
    parser.add_argument("--jobs", type=int, default=-1, help="processes (default: one per core)")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
