"""Fill the tables of our pages from the files that commands wrote; `--check` only says whether they are up to date.

docs/results/courses.json and maps.json are `compare.json` of the commands that README names, docs/results/bench.json is
`footsel bench --out`, docs/results/verify.json is written by `make verify`, and export/anymal_b/metrics.json by
`footsel export`; footsel/oracle/terrain_cost.json by `footsel terrain-cost fit`.
"""

import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"
TERRAIN_COST = ROOT / "footsel" / "oracle" / "terrain_cost.json"


def main() -> int:
    """Rewrite the tables, or with --check return 1 if that would change a page."""
    stale = []
    for page, tables in PAGES.items():
        path = ROOT / page
        before = path.read_text(encoding="utf-8")
        after = fill(page, before, tables)
        if after == before:
            continue
        stale.append(page)
        if "--check" not in sys.argv[1:]:
            path.write_text(after, encoding="utf-8")
    if "--check" in sys.argv[1:] and stale:
        print(f"{', '.join(stale)} out of date: run python docs/update_tables.py", file=sys.stderr)
        return 1
    return 0


def fill(page: str, text: str, tables: dict[str, Callable[[], str]]) -> str:
    """`text` with every table and value made anew."""
    for name, make in tables.items():
        place = re.search(rf"(?<=<!-- (table|value): {name} -->).*?(?=<!-- end -->)", text, re.DOTALL)
        if place is None:
            raise SystemExit(f"{page} has no place for {name}")
        text = text[: place.start()] + make() + text[place.end() :]
    return text


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


def slip() -> str:
    """How the terrain cost goes with measured slip."""
    figures = read(TERRAIN_COST)["figures"]
    groups = {
        "courses that were fitted": figures["fitted"],
        "courses that were not": figures["held_out"],
        "of these, cells drawn evenly": figures["held_out_uniform"],
        **{f"of these, {family}": scores for family, scores in figures["held_out_by_family"].items()},
    }
    return table(
        ["placements on", "number", "Spearman, worst quarter", "Spearman, mean slip", "mean slip [mm]"],
        [
            [
                name,
                str(scores["placements"]),
                number(scores["spearman_worst_quarter"], 3),
                number(scores["spearman_mean_slip"], 3),
                number(scores["mean_slip_mm"]),
            ]
            for name, scores in groups.items()
        ],
    )


def laws() -> str:
    """What shapes cost that everyone knows the answer for."""
    laws = read(TERRAIN_COST)["figures"]["laws"]

    def costs(shape: str) -> str:
        return ", ".join(f"{size}: {cost:.2f}" for size, cost in laws[shape].items())

    return table(
        ["shape", "cost"],
        [
            ["plane, by degrees", costs("slope_deg")],
            ["upper edge of a step, by cm", costs("upper_edge_cm")],
            ["foot of a step, by cm", costs("foot_of_step_cm")],
        ],
    )


def landmarks() -> str:
    """Cost and measured slip of shapes with a name."""
    found = read(TERRAIN_COST)["figures"]["landmarks"]
    return table(
        ["shape", "slip, measured", "cost"],
        [[name, f"{each['measured']:.2f}", f"{each['cost']:.2f}"] for name, each in found.items()],
    )


PAGES: dict[str, dict[str, Callable[[], str]]] = {
    "README.md": {
        "models": models,
        "courses": lambda: comparison("courses.json"),
        "maps": lambda: comparison("maps.json"),
        "speed": speed,
        "verify": verify,
    },
    "docs/terrain_cost.md": {"slip": slip, "laws": laws, "landmarks": landmarks},
}


if __name__ == "__main__":
    sys.exit(main())
