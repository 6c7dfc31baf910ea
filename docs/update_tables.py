"""Fill the tables of README.md from the files that commands wrote; `--check` only says whether they are up to date.

docs/results/courses.json and maps.json are `compare.json` of the commands that README names, docs/results/bench.json is
`footsel bench --out`, docs/results/verify.json is written by `make verify`, and export/anymal_b/metrics.json by
`footsel export`.
"""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
RESULTS = ROOT / "docs" / "results"


def main() -> int:
    """Rewrite README's tables, or with --check return 1 if that would change it."""
    before = README.read_text(encoding="utf-8")
    after = before
    for name, make in TABLES.items():
        place = re.search(rf"(?<=<!-- (table|value): {name} -->).*?(?=<!-- end -->)", after, re.DOTALL)
        if place is None:
            raise SystemExit(f"README.md has no place for {name}")
        after = after[: place.start()] + make() + after[place.end() :]
    if "--check" in sys.argv[1:]:
        if after != before:
            print("README.md is out of date: run python docs/update_tables.py", file=sys.stderr)
        return int(after != before)
    README.write_text(after, encoding="utf-8")
    return 0


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table on lines of its own; all columns but the first to the right."""
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def percent(value: float | None) -> str:
    """A share as a percentage."""
    return "-" if value is None else f"{100 * value:.2f} %"


def number(value: float | None, digits: int = 1) -> str:
    """A number, or a dash for none."""
    return "-" if value is None else f"{value:.{digits}f}"


def read(path: Path) -> Any:
    """A JSON file."""
    return json.loads(path.read_text(encoding="utf-8"))


def models() -> str:
    """Validation figures of the released models."""
    metrics = read(ROOT / "export" / "anymal_b" / "metrics.json")
    pairs = ("front", "hind")

    def row(label: str, group: str, key: str, form: Callable[[Any], str]) -> list[str]:
        return [label, *(form(metrics[pair][group][key]) for pair in pairs)]

    def recall(reason: str) -> list[str]:
        words = reason.lower().replace("_", " ")
        shares = (metrics[pair]["cells"]["recall_by_reason"][reason] for pair in pairs)
        return [f"cells of {words} called infeasible", *map(percent, shares)]

    return table(
        ["validation", *pairs],
        [
            row("accuracy over 14 classes, the most probable one", "cells_likeliest", "accuracy", percent),
            row("mean IoU of the same", "cells_likeliest", "miou_present", percent),
            row("accuracy by the selector's rule", "cells", "accuracy", percent),
            row("infeasible cells called feasible", "cells", "false_safe_rate", percent),
            row("feasible cells called infeasible", "cells", "false_unsafe_rate", percent),
            recall("KINEMATIC_RANGE"),
            recall("SELF_COLLISION"),
            recall("TERRAIN_COLLISION"),
            row("infeasible picks", "picks", "infeasible_rate", percent),
            row("missed, maps of 2000", "picks", "missed", str),
            row("mean regret", "picks", "regret_mean", number),
        ],
    )


def comparison(file: str) -> str:
    """Selectors of one compare.json, and what the network says of single cells."""
    result = read(RESULTS / file)
    rows = [
        [
            f"`{name}`",
            str(figures["picks"]),
            percent(figures["infeasible_rate"]),
            str(figures["missed"]),
            number(figures["regret_mean"]),
            number(figures["regret_p95"]),
        ]
        for name, figures in result["selectors"].items()
    ]
    cells = result["cells"]["cnn"]
    sentence = (
        f"\nCells of `cnn`: accuracy {percent(cells['accuracy'])}, mean IoU {percent(cells['miou_present'])}, "
        f"infeasible called feasible {percent(cells['false_safe_rate'])}, feasible called infeasible "
        f"{percent(cells['false_unsafe_rate'])}.\n"
    )
    return table(["selector", "picks", "infeasible picks", "missed", "mean regret", "95 % regret"], rows) + sentence


def speed() -> str:
    """Medians of bench.json."""
    bench = read(RESULTS / "bench.json")
    rows = [
        ["oracle, one 40x40 map", number(bench["oracle_ms_per_map"]["p50"], 2)],
        ["the same cell by cell, without tables (no margin)", number(bench["oracle_naive_ms_per_map"], 0)],
    ]
    for variant, times in bench["models"].items():
        rows += [
            [f"network `{variant}`, one map", number(times["network_ms"]["p50"], 2)],
            [f"network `{variant}`, elevation map to foothold, one leg", number(times["select_one_leg_ms"]["p50"], 2)],
            [f"network `{variant}`, the same, four legs", number(times["select_four_legs_ms"]["p50"], 2)],
        ]
    return table([f"median on one core of {bench['cpu']}", "ms"], rows)


def verify() -> str:
    """What `make verify` compared."""
    result = read(RESULTS / "verify.json")
    return (
        f"On {result['cells']:,} cells of every course family and ten maps made by others, four legs, tilts of up to "
        f"15 degrees: {result['differing_reasons']} differing reasons, terrain costs within "
        f"{result['terrain_cost_error']:.0e}, and {result['margins']} margins within "
        f"{1000 * result['margin_error']:.1f} mm."
    )


TABLES: dict[str, Callable[[], str]] = {
    "models": models,
    "courses": lambda: comparison("courses.json"),
    "maps": lambda: comparison("maps.json"),
    "speed": speed,
    "verify": verify,
}


if __name__ == "__main__":
    sys.exit(main())
