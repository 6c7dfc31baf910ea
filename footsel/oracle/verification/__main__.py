"""`python -m footsel.oracle.verification [MAPS...] --out verify.json`: every course family and the given maps."""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import joblib
import numpy as np
from tqdm import tqdm

from footsel.files import replace_file
from footsel.footholds import Reason
from footsel.legs import LEGS
from footsel.oracle import Oracle
from footsel.oracle.verification.comparison import MARGIN_BIN, Comparison, compare_source
from footsel.oracle.verification.parts import Parts, code_fingerprint
from footsel.terrain.courses import FAMILIES

#: What may differ. [cost of 1], [m]
TERRAIN_COST_TOLERANCE = 1e-6
MARGIN_TOLERANCE = 0.003

#: Lines of differing cells in the figures.
LISTED = 100


def main(argv: Sequence[str] | None = None) -> int:
    """Compare on every course family and the given maps, four legs each; 1 if anything differs."""
    options = _parser().parse_args(argv)
    sources = (*FAMILIES, *options.maps)
    work = [(source, leg) for source in sources for leg in LEGS]
    settings = {name: getattr(options, name) for name in ("cells", "cells_per_place", "margins", "seed")}
    parts = Parts(options.out.with_name(f"{options.out.name}.parts"), settings) if options.out else None
    Oracle.load()  # Its tables are made here, once, if at all.

    done: dict[tuple[str, str], Comparison] = {}
    for source, leg in work:
        if parts and (stored := parts.read(source, leg)):
            done[source, leg] = Comparison(**stored)
    left = [each for each in work if each not in done]
    if done:
        print(f"{len(done)} of {len(work)} parts were compared before", file=sys.stderr)
    results = joblib.Parallel(n_jobs=options.jobs, return_as="generator_unordered")(
        joblib.delayed(_part)(source, leg, settings) for source, leg in left
    )
    for source, leg, part in tqdm(results, total=len(work), initial=len(done), desc="verify", unit="part"):
        for line in part.differing:
            print(line, flush=True)
        if parts:
            parts.write(source, leg, part.to_dict())
        done[source, leg] = part

    figures = summary({each: done[each] for each in work}, settings)
    text = json.dumps(figures, indent=1) + "\n"
    print(table(figures))
    if options.out:
        replace_file(options.out, lambda path: path.write_text(text, encoding="utf-8"))
    return int(not figures["passed"])


def summary(parts: Mapping[tuple[str, str], Comparison], settings: Mapping[str, Any]) -> dict[str, Any]:
    """The figures of all parts, by (source, leg)."""
    total = Comparison.sum(parts.values())
    errors = total.margin_errors
    margin_error = float(errors.max(initial=0.0))
    by_source = {
        Path(source).name: _shares(Comparison.sum(part for (name, _), part in parts.items() if name == source))
        for source in dict.fromkeys(source for source, _ in parts)
    }
    return {
        "passed": not total.differing
        and total.terrain_cost_error <= TERRAIN_COST_TOLERANCE
        and margin_error <= MARGIN_TOLERANCE,
        "cells": total.cells,
        "known_cells": total.known_cells,
        "cells_by_reason": {reason.name: total.reasons[reason] for reason in Reason},
        "differing_reasons": len(total.differing),
        "differing": total.differing[:LISTED],
        "terrain_cost_error": total.terrain_cost_error,
        "margins": len(errors),
        "margin_error": margin_error,
        "margin_error_mean": float(errors.mean()) if len(errors) else 0.0,
        "margins_by_size": _by_size(total),
        "local_maps": total.places,
        "base_height_m": [round(height, 3) for height in total.heights],
        "tilt_deg": round(float(np.rad2deg(total.tilt)), 2),
        "legs": sorted({leg for _, leg in parts}),
        "by_source": by_source,
        "settings": dict(settings),
        "code": code_fingerprint(),
    }


def table(figures: Mapping[str, Any]) -> str:
    """What `make verify` prints."""
    names = [reason.name for reason in Reason if reason != Reason.UNKNOWN]
    lines = [
        f"{'shares of known cells':34}" + "".join(f"{name.lower():>19}" for name in names) + f"{'known cells':>13}"
    ]
    for source, row in figures["by_source"].items():
        shares = "".join(f"{100 * row['shares'][name]:17.2f} %" for name in names)
        lines.append(f"{source:34}{shares}{row['known_cells']:13}")
    low, high = figures["base_height_m"]
    lines += [
        "",
        f"{figures['cells']} cells ({figures['known_cells']} known) of {figures['local_maps']} local maps",
        f"base {low} to {high} m above ground, roll and pitch to {figures['tilt_deg']} degrees",
        f"differing reasons: {figures['differing_reasons']}",
        f"largest difference of terrain cost: {figures['terrain_cost_error']:.2g}",
        f"{figures['margins']} margins, error {1e3 * figures['margin_error']:.2f} mm at most, "
        f"{1e3 * figures['margin_error_mean']:.3f} mm on average",
        "passed" if figures["passed"] else "FAILED",
    ]
    return "\n".join(lines)


def _part(source: str, leg: str, settings: Mapping[str, Any]) -> tuple[str, str, Comparison]:
    return source, leg, compare_source(source, leg, **settings)


def _shares(part: Comparison) -> dict[str, Any]:
    """One source's figures: the share of its known cells that each constraint decides, and its margins."""
    known = max(part.known_cells, 1)
    errors = part.margin_errors
    return {
        "known_cells": part.known_cells,
        "shares": {reason.name: part.reasons[reason] / known for reason in Reason if reason != Reason.UNKNOWN},
        "differing_reasons": len(part.differing),
        "margins": len(errors),
        "margin_error": float(errors.max(initial=0.0)),
    }


def _by_size(total: Comparison) -> list[dict[str, float]]:
    """Errors of the margins by their size."""
    if not total.margins:
        return []
    bins = np.floor(np.array(total.margins)[:, 1] / MARGIN_BIN).astype(int)
    errors = total.margin_errors
    return [
        {
            "from_m": round(number * MARGIN_BIN, 3),
            "to_m": round((number + 1) * MARGIN_BIN, 3),
            "margins": int((bins == number).sum()),
            "error": float(errors[bins == number].max()),
        }
        for number in np.unique(bins).tolist()
    ]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m footsel.oracle.verification", description=__doc__)
    parser.add_argument("maps", nargs="*", metavar="MAP", help="elevation maps to compare on as well")
    parser.add_argument(
        "--out", type=Path, help="write the figures to this JSON file; finished parts wait in a folder beside it"
    )
    parser.add_argument("--cells", type=int, default=2400, help="known cells per source and leg (default %(default)s)")
    parser.add_argument("--cells-per-place", type=int, default=200, help="at most, per local map (default %(default)s)")
    parser.add_argument("--margins", type=int, default=25, help="margins per source and leg (default %(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of all that is random (default %(default)s)")
    parser.add_argument("--jobs", type=int, default=-1, help="processes (default: one per core)")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
