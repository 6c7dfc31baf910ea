"""Judge a model's 8-bit variant beside float32, and keep the figures in docs/results/int8.json.

python docs/judge_int8.py MODEL [MAPS...] --jobs 2

The same base poses on the built-in courses, and on MAPS if there are any, until there are 20,000 picks on each; the
exact oracle judges. What eight bits may cost at most: LIMITS. Exits 1 if they cost more.
"""

import argparse
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from footsel import ElevationMap
from footsel.comparison.compare import compare
from footsel.comparison.maps import NamedMap, built_in_courses
from footsel.errors import FootselError, InputError
from footsel.files import write_json
from footsel.legs import LEGS

RESULTS = Path(__file__).resolve().parent / "results"
FLOAT32, INT8 = "cnn", "cnn:int8"
#: Picks that are judged at least, by each variant and on each kind of ground.
PICKS = 20_000
SEED = 8
#: By how much eight bits may be worse: mean regret, and infeasible picks as a share of the picks.
LIMITS = {"regret_mean": 0.5, "infeasible_rate": 0.001}
FIGURES = ("picks", "missed", "infeasible_picks", "infeasible_rate", "regret_mean", "regret_p95")


def main() -> int:
    """Compare on both kinds of ground, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", metavar="MODEL", type=Path)
    parser.add_argument("maps", metavar="MAPS", nargs="*", type=Path)
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: %(default)s)")
    parser.add_argument("--picks", type=int, default=PICKS, help="on each kind of ground (default: %(default)s)")
    args = parser.parse_args()
    try:
        grounds = {"courses": built_in_courses(SEED)}
        if args.maps:
            grounds["maps"] = [NamedMap(path.stem, ElevationMap.load(path)) for path in args.maps]
        found = {name: judged(args.model, maps, args.picks, args.jobs) for name, maps in grounds.items()}
    except FootselError as error:
        print(f"judge_int8.py: error: {error}", file=sys.stderr)
        return 2
    write_json(RESULTS / "int8.json", {"limits": LIMITS, "seed": SEED, "grounds": found})
    for name, figures in found.items():
        print(name, figures["worse_by"], "within the limits" if figures["within_limits"] else "BEYOND THE LIMITS")
    return 0 if all(figures["within_limits"] for figures in found.values()) else 1


def judged(model: Path, maps: Sequence[NamedMap], picks: int, jobs: int) -> dict[str, Any]:
    """Figures of both variants on some maps, and by how much eight bits are worse."""
    # Where a leg has no foothold there is no pick, so the first count says how many poses it takes.
    needed, found = picks, 0
    while found < picks:
        each = math.ceil(needed / len(LEGS) / len(maps))
        figures = compare(maps, [FLOAT32, INT8], poses=each, seed=SEED, jobs=jobs, model=model).figures()
        selectors = figures["selectors"]
        found = min(selectors[name]["picks"] for name in (FLOAT32, INT8))
        if not found:
            raise InputError("there are no picks to judge", "give maps with footholds")
        needed = math.ceil(1.02 * needed * picks / found)
    worse = {key: _worse(selectors, key) for key in LIMITS}
    return {
        "maps": figures["maps"],
        "poses": each,
        "questions": each * len(maps) * len(LEGS),
        "selectors": {name: {key: picks[key] for key in FIGURES} for name, picks in selectors.items()},
        "worse_by": worse,
        "within_limits": all(worse[key] <= most for key, most in LIMITS.items()),
    }


def _worse(selectors: Mapping[str, Any], key: str) -> float:
    return float(selectors[INT8][key] or 0.0) - float(selectors[FLOAT32][key] or 0.0)


if __name__ == "__main__":
    sys.exit(main())
