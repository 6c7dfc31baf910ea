"""Fill the tables of our pages from the files that commands wrote; `--check` only says whether they are up to date.

COMMANDS says what writes the files of docs/results; courses.json and maps.json are `compare.json`, walks.json and its
like are `walks.json` of the commands that README and docs/walking.md name. export/anymal_b/metrics.json is written by
`footsel export`, footsel/oracle/terrain_cost.json by `footsel terrain-cost fit`. Where a file is missing, the page says
what would make it.
"""

import errno
import json
import re
import statistics
import sys
from collections import Counter
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "docs" / "results"
TERRAIN_COST = ROOT / "footsel" / "oracle" / "terrain_cost.json"

#: What writes a file of docs/results.
COMMANDS = {
    "ablations.json": "python docs/ablations.py",
    "bench.json": "make bench-full",
    "bench_avx2.json": "footsel bench",
    "clearance.json": "python docs/measure_clearance.py",
    "courses.json": "footsel compare",
    "dataset.json": "python docs/measure_dataset.py",
    "degraded.json": "python docs/judge.py degraded",
    "held_out.json": "python docs/judge.py held_out",
    "int8.json": "python docs/judge_int8.py",
    "label.txt": "python docs/make_figures.py",
    "maps.json": "footsel compare",
    "mapping.json": "python docs/measure_mapping.py",
    "paper.json": "python docs/judge.py paper",
    "verify.json": "make verify",
    "verify_meshes.json": "make verify-meshes",
    "verify_pybullet.json": "make verify-pybullet",
    "walks.json": "footsel compare --walk",
    "walks_camera.json": "footsel compare --walk --map camera",
    "walks_classic.json": "footsel compare --walk stairs stones",
    "walks_maps.json": "footsel compare --walk MAPS",
    "walks_noisy.json": "footsel compare --walk --map noisy",
    "walks_others.json": "footsel compare --walk stones_hard gaps rough slopes stairs12 flat",
    "walks_unwatched.json": "footsel compare --walk --no-limb-watch",
}


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
        try:
            made = make()
        except FileNotFoundError as missing:
            made = f"*not measured yet: `{COMMANDS[Path(missing.filename).name]}`*"
            made = made if place[1] == "value" else f"\n{made}\n"
        text = text[: place.start()] + made + text[place.end() :]
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


def words(name: str) -> str:
    """A name of the code as a reader says it."""
    return name.lower().replace("_", " ")


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
        shares = (metrics[pair]["cells"]["recall_by_reason"][reason] for pair in pairs)
        return [f"cells of {words(reason)} called infeasible", *map(percent, shares)]

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
            row("missed, share of the maps with a foothold", "picks", "missed_rate", percent),
            row("mean regret", "picks", "regret_mean", number),
        ],
    )


#: What the paper reports on its validation set (its table I): accuracy and IoU of the front and the rear model.
PAPER_REPORTS = {"front": (0.8261, 0.499), "hind": (0.8261, 0.4988)}


def paper() -> str:
    """Our training by the paper's recipe beside the paper's figures."""
    networks = read(RESULTS / "paper.json")["networks"]
    rows = []
    for pair, (accuracy, iou) in PAPER_REPORTS.items():
        own, unseen = (networks[pair][key]["cells_likeliest"] for key in ("validation", "unseen"))
        for name, reported, key in (("accuracy", accuracy, "accuracy"), ("IoU", iou, "miou")):
            rows.append([f"{name}, {pair}", percent(reported), percent(own[key]), percent(unseen[key])])
    front = networks["front"]
    head = ["14 classes, the most probable one", "the paper, 500 epochs"]
    head += [f"ours, {front['epochs']} epochs, its own map", f"the same, {', '.join(front['exclude'])}: never seen"]
    return table(head, rows)


def held_out() -> str:
    """Families seen in training and families that were not."""
    networks = read(RESULTS / "held_out.json")["networks"]
    rows = []
    for pair, found in networks.items():
        groups = {"families trained on": found["seen"], "families never seen": found["unseen"]}
        groups |= {f"of these, {name}": figures for name, figures in found["families"].items()}
        groups["families never seen, poses as compared"] = found["unseen_as_compared"]
        rows += [
            [
                f"{pair}, {name}",
                percent(group["cells_likeliest"]["accuracy"]),
                percent(group["cells_likeliest"]["miou_present"]),
                percent(group["cells"]["false_safe_rate"]),
                percent(group["picks"]["infeasible_rate"]),
                percent(group["picks"]["missed_rate"]),
                number(group["picks"]["regret_mean"]),
            ]
            for name, group in groups.items()
        ]
    figures = ["accuracy", "mean IoU", "false-safe", "infeasible picks", "missed", "mean regret"]
    return table(["maps", *figures], rows)


def degraded() -> str:
    """Picks from degraded maps, of the networks and of the oracle."""
    result = read(RESULTS / "degraded.json")
    names = {
        "none": "the true map",
        "noise": "`--noise d435`",
        "holes": "`--holes 0.2`",
        "both": "both",
    }
    rows = []
    for poses, group in (("as compared", result["as_compared"]), ("dataset", result)):
        for whose, by_network in (("network", group["networks"]), ("oracle", group["oracle"])):
            for key, name in names.items():
                row = [poses, f"{whose}, {name}"]
                for network in group["networks"]:
                    found = by_network[network][key]
                    picks = found["picks"] if whose == "network" else found
                    row += [percent(picks["infeasible_rate"]), percent(picks["missed_rate"])]
                    row += [number(picks["regret_mean"])]
                rows.append(row)
    figures = ("infeasible picks", "missed", "mean regret")
    head = ["poses", "input", *(f"{network}: {figure}" for network in result["networks"] for figure in figures)]
    return table(head, rows)


def clearance() -> str:
    """What a small network makes of each way to compute the leg's clearance."""
    rows = [
        [
            name,
            percent(row["errors"]),
            percent(row["errors_where_few"]),
            percent(row["taken_for_feasible"]["0.01"]),
            percent(row["taken_for_feasible"]["0.03"]),
        ]
        for name, row in read(RESULTS / "clearance.json")["variants"].items()
    ]
    head = [
        "clearance",
        "cells told wrongly",
        "on maps with few footholds",
        "collisions missed, 1 % of the feasible given away",
        "the same, 3 %",
    ]
    return table(head, rows)


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


def eight_bits() -> str:
    """The 8-bit variant beside float32."""
    result = read(RESULTS / "int8.json")
    rows = []
    for ground, found in result["grounds"].items():
        for name, picks in found["selectors"].items():
            rows.append(
                [
                    f"{ground}, `{name}`",
                    f"{picks['picks']:,}",
                    percent(picks["infeasible_rate"]),
                    f"{picks['missed']:,}",
                    number(picks["regret_mean"], 2),
                    number(picks["regret_p95"]),
                ]
            )
    limits = result["limits"]
    verdicts = ", ".join(
        f"on {ground} by {found['worse_by']['regret_mean']:+.2f} in mean regret and by "
        f"{100 * found['worse_by']['infeasible_rate']:+.2f} points in infeasible picks"
        for ground, found in result["grounds"].items()
    )
    kept = "within" if all(found["within_limits"] for found in result["grounds"].values()) else "beyond"
    sentence = (
        f"\nEight bits are worse {verdicts}: {kept} the limits of {limits['regret_mean']:g} and "
        f"{100 * limits['infeasible_rate']:g}.\n"
    )
    return table(["", "picks", "infeasible picks", "missed", "mean regret", "95 % regret"], rows) + sentence


def walks(file: str) -> str:
    """Success rates of a comparison of walks, with their intervals."""
    summary = read(RESULTS / file)["summary"]
    selectors = list(dict.fromkeys(name for parts in summary.values() for name in parts))
    rows = []
    for terrain, parts in summary.items():
        rates = [_rate(parts[name]) if name in parts else "-" for name in selectors]
        rows.append([_terrain(terrain), str(next(iter(parts.values()))["n"]), *rates])
    return table(["terrain", "walks each", *(f"`{name}`" for name in selectors)], rows)


def walk_means(file: str) -> str:
    """What walks came to, over those that reached the goal."""
    rows = [
        [
            _terrain(terrain),
            f"`{name}`",
            str(round(part["n"] * part["success_rate"])),
            *(number(part["means_of_successes"][metric], digits) for metric, (_, digits) in WALK_METRICS.items()),
        ]
        for terrain, parts in read(RESULTS / file)["summary"].items()
        for name, part in parts.items()
        if part["means_of_successes"] is not None
    ]
    return table(["terrain", "selector", "arrived", *(heading for heading, _ in WALK_METRICS.values())], rows)


def walk_contacts(file: str) -> str:
    """How often and how long limbs touch the ground, over all walks."""
    rows = []
    found = read(RESULTS / file)
    for terrain, parts in found["summary"].items():
        for name, part in parts.items():
            runs = [run for run in found["runs"] if (run["terrain"], run["selector"]) == (terrain, name)]
            touching = sum(run["hind_shank_contact_s"] > 0 for run in runs)
            means = [number(part["means"][metric], 2) for metric in ("hind_shank_contact_s", "shank_impacts")]
            rows.append([_terrain(terrain), f"`{name}`", str(part["n"]), str(touching), *means])
    head = [
        "terrain",
        "selector",
        "walks",
        "with hind shanks on the ground",
        "for [s], mean",
        "hard shank impacts, mean",
    ]
    return table(head, rows)


def walk_differences(file: str) -> str:
    """The network minus each other selector, seed by seed."""
    metrics = {
        "success": "success",
        "shank_impacts": "hard shank impacts",
        "hind_shank_contact_s": "hind shanks touch [s]",
    }
    rows = [
        [_terrain(terrain), f"`{name}`", *(_difference(entry[metric]) for metric in metrics)]
        for terrain, others in read(RESULTS / file)["network_minus"].items()
        for name, entry in others.items()
    ]
    return table(["terrain", "`cnn` minus", *metrics.values()], rows)


def gains() -> str:
    """What the controller of a walk is made with, from the code itself."""
    rows = [[what, ", ".join(_value(place, name) for name in names), source] for what, place, names, source in GAINS]
    return table(["", "value", "from"], rows)


_OURS, _FREE_GAIT = "trial", "the idea free_gait's, the size trial"
#: What it is, module below footsel.walking, constants, where they come from.
GAINS = (
    ("control and physics, one step [s]", "simulation.simulation", ["TIME_STEP"], _OURS),
    ("base: stiffness, linear and angular [1/s²]", "gait.walker", ["BASE_STIFFNESS"], _OURS),
    ("base: damping [1/s]", "gait.walker", ["BASE_DAMPING"], _OURS),
    ("swinging foot: stiffness, damping", "gait.walker", ["SWING_STIFFNESS", "SWING_DAMPING"], _OURS),
    ("standing foot: damping [1/s]", "gait.walker", ["STANCE_DAMPING"], _OURS),
    ("most torque [Nm]", "control.whole_body", ["TORQUE_LIMIT"], "effort limits of ANYmal B's URDF"),
    ("friction: true", "simulation.simulation", ["FRICTION"], "rubber on stone"),
    (
        "friction: the controller's, along a side of the pyramid",
        "control.whole_body",
        ["FRICTION"],
        "below the true one",
    ),
    ("centre of mass inside the support [m]", "control.base_pose", ["STABILITY_MARGIN"], _FREE_GAIT),
    ("longest leg, hip point to foot [m]", "control.base_pose", ["LONGEST_LEG"], "0.564 m is the stretched leg"),
    ("stride [m]", "gait.planner", ["STRIDE"], _OURS),
    ("height of the base over its feet [m]", "gait.stance", ["HEIGHT"], _OURS),
    ("share of the ground's tilt that the base takes", "gait.poses", ["TILT_SHARE"], _OURS),
    ("swing: clearance over the map [m]", "gait.swing", ["CLEARANCE"], _OURS),
    ("touchdown: felt from [N]", "gait.walker", ["TOUCHDOWN_FORCE"], _OURS),
    ("touchdown: speed [m/s]", "gait.swing", ["TOUCHDOWN_SPEED"], _OURS),
)


def _value(module: str, name: str) -> str:
    value = getattr(import_module(f"footsel.walking.{module}"), name)
    return " ".join(f"{part:g}" for part in value) if hasattr(value, "__len__") else f"{value:g}"


#: Of a walk -> heading, digits.
WALK_METRICS = {
    "slip_max_mm": ("worst slip [mm]", 0),
    "shank_impacts": ("hard shank impacts", 2),
    "hind_shank_contact_s": ("hind shanks touch [s]", 2),
    "tracking_error_mm": ("tracking error [mm]", 0),
    "min_stability_margin_m": ("least margin [m]", 3),
    "duration_s": ("time [s]", 0),
    "realtime_factor": ("times real time", 1),
}


def _terrain(name: str) -> str:
    """A terrain's name, or that of a map's file."""
    return Path(name).stem


def _rate(part: dict[str, Any]) -> str:
    low, high = part["ci95"]
    return f"{part['success_rate']:.0%} ({100 * low:.0f}–{100 * high:.0f})"


def _difference(entry: dict[str, Any] | None) -> str:
    if entry is None:
        return "-"
    sure = "**" if entry["sign_test_p"] < 0.05 else ""
    low, high = entry["ci95"]
    return f"{sure}{entry['mean']:+.2f}{sure} ({low:+.2f} to {high:+.2f})".replace("-", "−")


def mapping() -> str:
    """The camera map on walking courses."""
    result = read(RESULTS / "mapping.json")
    head = [f"{result['seeds']} courses of each, mean", "cells known", "the same beside no edge", "median error [mm]"]
    head += ["95 % [mm]", "too high", "too low", "normalised error", "pose off by [mm]"]
    rows = [
        [
            name,
            percent(course["known"]),
            percent(course["known_even"]),
            number(course["median_mm"]),
            number(course["p95_mm"]),
            percent(course["too_high"]),
            percent(course["too_low"]),
            number(course["normalised"], 2),
            number(course["drift_mm"]),
        ]
        for name, course in result["courses"].items()
    ]
    return table(head, rows)


def mapping_times() -> str:
    """What an image costs."""
    result = read(RESULTS / "mapping.json")
    steps = {
        "render": "TinyRenderer's true depth",
        "read": "`D435.read`",
        "bodies": "the robot's capsules",
        "integrate": "`ElevationMapping.integrate`",
    }
    rows = [[name, number(result["time_ms"][step])] for step, name in steps.items()]
    return table([f"one image of 424x240, median on one core of {result['cpu']}", "ms"], rows)


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
    faster = (
        f"\nMap by map, the oracle is {bench['oracle_times_as_fast']:,} times as fast as the loop over its cells.\n"
    )
    return table([f"median on one core of {bench['cpu']}", "ms"], rows) + faster


def of_full_benchmark(key: str) -> Any:
    """A part of bench.json that only the full benchmark has."""
    path = RESULTS / "bench.json"
    try:
        return read(path)[key]
    except KeyError:
        raise FileNotFoundError(errno.ENOENT, f"no {key}", str(path)) from None


def latency() -> str:
    """Percentiles of the runtime in Python and C++, and of the same network in other hands."""
    cpp, bench = of_full_benchmark("cpp"), read(RESULTS / "bench.json")
    rows: dict[str, Any] = {}
    for variant, times in bench["models"].items():
        for language, found in (("", times), (" in C++", cpp.get(variant, {}))):
            for what, key in (("one leg", "select_one_leg_ms"), ("four legs", "select_four_legs_ms")):
                if key in found:
                    rows[f"`{variant}`{language}, {what}"] = found[key]
            if "other_core_busy" in found:
                rows[f"`{variant}`, four legs, the other core busy"] = found["other_core_busy"]["select_four_legs_ms"]
        rows[f"`{variant}`, the network alone"] = times["network_ms"]
    for name, times in bench["other_models"].items():
        for what, key in (("one leg", "select_one_leg_ms"), ("four legs", "select_four_legs_ms")):
            rows[f"`{name}`, stock ERFNet, {what}"] = times[key]
    names = {
        "torch_eager": "the same network in torch",
        "onnxruntime_unsimplified": "in onnxruntime, as torch exports it",
        "onnxruntime_default_options": "in onnxruntime with its own options, all cores",
    }
    rows |= {names[name]: found["network_ms"] for name, found in bench["baselines"].items()}
    rows["the exact oracle, one map"] = bench["oracle_ms_per_map"]
    head = [f"ms on one core of {bench['cpu']}", "median", "99 %", "99.9 %"]
    return table(
        head, [[name, *(number(times.get(p), 2) for p in ("p50", "p99", "p999"))] for name, times in rows.items()]
    )


def latency_without_avx512() -> str:
    """Medians on a core with and on one without AVX-512, beside the speed of a matrix product on each."""
    machines = [read(RESULTS / "bench.json"), read(RESULTS / "bench_avx2.json")]
    times = {"default": [each["models"][each["default"]] for each in machines]}
    for name in machines[0]["other_models"]:
        times[f"`{name}`, stock ERFNet"] = [each["other_models"][name] for each in machines]
    rows = [
        [f"{name}, {legs}", *(number(each[key]["p50"], 2) for each in found)]
        for name, found in times.items()
        for legs, key in (("one leg", "select_one_leg_ms"), ("four legs", "select_four_legs_ms"))
    ]
    rows.append(["the exact oracle, one map", *(number(each["oracle_ms_per_map"]["p50"], 2) for each in machines)])
    head = [f"{each['matmul_gflops']:.0f} GFLOP/s" for each in machines]
    return table(["median in ms on a core that multiplies matrices at", *head], rows)


#: Bins of the histogram that one row of the page takes together.
BINS_PER_ROW = 5


def histogram() -> str:
    """How the times of very many selections are spread."""
    found = of_full_benchmark("histogram")
    kinds = {
        f"{words(kind)}, {words(other)}": times
        for kind in ("one_leg", "four_legs")
        for other, times in found[kind].items()
    }
    edges = found["edges_ms"][::BINS_PER_ROW]
    rows = []
    for row in range(len(edges) - 1):
        bins = slice(row * BINS_PER_ROW, (row + 1) * BINS_PER_ROW)
        counts = [sum(times["counts"][bins]) for times in kinds.values()]
        if any(counts):
            rows.append([f"{edges[row]:.3g} to {edges[row + 1]:.3g} ms", *(f"{count:,}" for count in counts)])
    for key, name in {"p50": "median", "p99": "99 %", "p999": "99.9 %", "max": "longest"}.items():
        rows.append([f"{name} [ms]", *(number(times[key], 2) for times in kinds.values())])
    return table([f"{found['calls']:,} calls each", *kinds], rows)


def throughput() -> str:
    """Maps per second by batch."""
    cpp, rates = of_full_benchmark("cpp"), read(RESULTS / "bench.json")["maps_per_second"]
    rows = {f"`{variant}`, {words(name)}": each for variant, groups in rates.items() for name, each in groups.items()}
    rows |= {f"`{variant}` in C++, one core": found["maps_per_second"] for variant, found in cpp.items()}
    batches = list(next(iter(rows.values())))
    return table(
        ["maps per second, batch", *batches],
        [[name, *(f"{each[batch]:,.0f}" for batch in batches)] for name, each in rows.items()],
    )


def speed_by_terrain() -> str:
    """The oracle's time on each family."""
    bench = read(RESULTS / "bench.json")
    groups = {"all": bench["oracle_ms_per_map"], **bench["oracle_ms_by_terrain"]}
    # Not families, but the same maps by the base's tilt.
    groups["base level"], groups["base tilted"] = groups.pop("level"), groups.pop("tilted")
    return table(
        [f"one 40x40 map, one core of {bench['cpu']}", "median [ms]", "99 % [ms]"],
        [[name, number(times["p50"], 2), number(times["p99"], 2)] for name, times in groups.items()],
    )


def speed_by_stage() -> str:
    """The oracle's constraints, all cells at once and one by one."""
    stages = read(RESULTS / "bench.json")["oracle_us_per_cell"]
    return table(
        ["microseconds a cell", "oracle", "reference", "times as fast"],
        [
            [words(stage), number(times["fast"], 2), f"{times['naive']:,.0f}", f"{times['naive'] / times['fast']:,.0f}"]
            for stage, times in stages.items()
        ],
    )


def verify() -> str:
    """What `make verify` compared."""
    result = read(RESULTS / "verify.json")
    known = result["cells"] - result["cells_by_reason"]["UNKNOWN"]
    return (
        f"On {known:,} known cells of every course family and ten maps made by others, four legs, tilts of up to "
        f"15 degrees: {result['differing_reasons']} differing reasons, terrain costs within "
        f"{result['terrain_cost_error']:.0e}, and {result['margins']:,} margins within "
        f"{1000 * result['margin_error']:.1f} mm."
    )


def verified_reasons() -> str:
    """How many cells of each reason were compared."""
    counts = read(RESULTS / "verify.json")["cells_by_reason"]
    return table(["the first constraint that fails", "cells"], [[words(name), f"{n:,}"] for name, n in counts.items()])


def pybullet() -> str:
    """How PyBullet's contacts agree with ours."""
    result = read(RESULTS / "verify_pybullet.json")
    return (
        f"Of {result['cells']:,} cells in kinematic range {result['disagreements']:,} are judged differently, all "
        f"within {1000 * result['largest_distance']:.1f} mm of touching."
    )


def meshes() -> str:
    """How the full meshes differ from the primitives."""
    result = read(RESULTS / "verify_meshes.json")
    median, most = (1000 * result["distances"][key] for key in ("median", "max"))
    return (
        f"Of {result['cells']:,} cells in kinematic range {result['disagreements']:,} "
        f"({percent(result['disagreements'] / result['cells'])}) are judged differently, half of them within "
        f"{median:.1f} mm of touching, the worst {most:.1f} mm."
    )


def contacts(file: str, other: str) -> str:
    """Both kinds of collision, who sees them."""
    result = read(RESULTS / file)
    columns = {
        "both": "both see it",
        "oracle_only": "the oracle alone",
        "other_only": f"{other} alone",
        "neither": "none",
    }
    return table(
        ["collision", *columns.values()],
        [
            [words(f"{kind}_collision"), *(f"{result[kind][column]:,}" for column in columns)]
            for kind in ("self", "terrain")
        ],
    )


def mesh_bodies() -> str:
    """Where meshes and primitives differ most, the four legs together."""
    cells: Counter[tuple[str, str]] = Counter()
    for row in read(RESULTS / "verify_meshes.json")["by_bodies"]:
        seen_by = "primitives alone" if row["seen_by"] == "oracle" else "meshes alone"
        cells[re.sub(r"\b[LR][FH]_", "", row["bodies"]), seen_by] += row["cells"]
    return table(
        ["bodies", "seen by", "cells"],
        [[bodies, seen_by, str(count)] for (bodies, seen_by), count in cells.most_common(8)],
    )


def explanation() -> str:
    """What `footsel label` says."""
    return "\n```\n" + (RESULTS / "label.txt").read_text(encoding="utf-8") + "```\n"


def dataset() -> str:
    """How long a dataset took."""
    result = read(RESULTS / "dataset.json")
    return (
        f"`{result['command']}`: {result['samples']:,} maps in {result['seconds']:.0f} s on {result['cores']} cores of "
        f"{result['cpu']}, {result['peak_memory_mb']:,} MB of memory at most, {result['disk_mb']:,} MB on disk."
    )


def dataset_families() -> str:
    """What decides the cells of each family."""
    result = read(RESULTS / "dataset.json")
    reasons = list(result["reason_shares"])
    groups = {"all": result, **result["families"]}
    return table(
        ["terrain", "maps", "unknown", *(f"{words(reason)}, of known" for reason in reasons)],
        [
            [
                name,
                f"{group['samples']:,}",
                percent(group["unknown_share"]),
                *(percent(group["reason_shares"][reason]) for reason in reasons),
            ]
            for name, group in groups.items()
        ],
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


def ablations_picks() -> str:
    """Footholds of each row of ablations.json, where equally many are missed and at the row's own threshold."""
    result = read(RESULTS / "ablations.json")
    shares = list(result["rows"][0]["at_missed"])

    def at(row: dict[str, Any], share: str) -> str:
        found = row["at_missed"][share]
        return "-" if found is None else f"{percent(found['infeasible_rate'])}, {number(found['regret_mean'])}"

    rows = [
        [
            row["name"],
            *(at(row, share) for share in shares),
            f"{percent(row['picks']['infeasible_rate'])}, {number(row['picks']['regret_mean'])}",
            percent(row["picks"]["missed_rate"]),
        ]
        for row in result["rows"]
    ]
    at_shares = [f"at {100 * float(share):.0f} % missed" for share in shares]
    return table(["infeasible picks, mean regret", *at_shares, "at its threshold", "missed there"], rows)


def ablations_cells() -> str:
    """Cells of each row of ablations.json."""
    rows = [
        [
            row["name"],
            percent(row["cells_likeliest"]["accuracy"]),
            percent(row["cells_likeliest"]["accuracy_feasible"]),
            percent(row["cells_likeliest"]["miou_present"]),
            percent(row["cells"]["false_safe_rate"]),
            percent(row["cells"]["false_unsafe_rate"]),
            percent(row["cells"]["recall_by_reason"]["TERRAIN_COLLISION"]),
            f"{row['parameters']:,}",
        ]
        for row in read(RESULTS / "ablations.json")["rows"]
    ]
    figures = ["accuracy", "on feasible cells", "mean IoU", "false-safe", "false-unsafe", "terrain collisions found"]
    return table(["cells", *figures, "parameters"], rows)


def ablations_conditions() -> str:
    """What all rows of ablations.json have in common."""
    result = read(RESULTS / "ablations.json")
    training, test = result["training"]["config"], result["test"]["config"]
    arithmetic = "bfloat16" if result["bfloat16"] else "float32"
    minutes = statistics.median(row["minutes"] for row in result["rows"])
    return (
        f"{result['base']['maps']:,} maps for {result['base']['epochs']} epochs if a row says nothing else, of a "
        f"dataset of {training['maps']:,} (seed {training['seed']}); judged on {test['maps']:,} maps of seed "
        f"{test['seed']}; half of the rows took more than {minutes:.0f} minutes on one thread of {result['cpu']}, "
        f"which other work shared, {arithmetic}."
    )


PAGES: dict[str, dict[str, Callable[[], str]]] = {
    "README.md": {
        "models": models,
        "paper": paper,
        "courses": lambda: comparison("courses.json"),
        "maps": lambda: comparison("maps.json"),
        "walks": lambda: walks("walks.json"),
        "speed": speed,
        "verify": verify,
        "pybullet": pybullet,
        "meshes": meshes,
        "dataset": dataset,
    },
    "docs/dataset.md": {"dataset": dataset, "families": dataset_families},
    "docs/judging.md": {"degraded": degraded},
    "docs/learning.md": {
        "clearance": clearance,
        "held out": held_out,
        "conditions": ablations_conditions,
        "picks": ablations_picks,
        "cells": ablations_cells,
    },
    "docs/oracle.md": {
        "explanation": explanation,
        "verify": verify,
        "reasons": verified_reasons,
        "pybullet": pybullet,
        "pybullet contacts": lambda: contacts("verify_pybullet.json", "PyBullet"),
        "meshes": meshes,
        "mesh contacts": lambda: contacts("verify_meshes.json", "meshes"),
        "mesh bodies": mesh_bodies,
        "terrain": speed_by_terrain,
        "stages": speed_by_stage,
    },
    "docs/runtime.md": {
        "latency": latency,
        "latency without avx512": latency_without_avx512,
        "histogram": histogram,
        "throughput": throughput,
        "eight bits": eight_bits,
    },
    "docs/walking.md": {
        "gains": gains,
        "walks": lambda: walks("walks.json"),
        "differences": lambda: walk_differences("walks.json"),
        "means": lambda: walk_means("walks.json"),
        "unwatched": lambda: walk_contacts("walks_unwatched.json"),
        "others": lambda: walks("walks_others.json"),
        "classic": lambda: walks("walks_classic.json"),
        "camera": lambda: walks("walks_camera.json"),
        "noisy": lambda: walks("walks_noisy.json"),
        "maps": lambda: walks("walks_maps.json"),
    },
    "docs/mapping.md": {"mapping": mapping, "times": mapping_times},
    "docs/terrain_cost.md": {"slip": slip, "laws": laws, "landmarks": landmarks},
}


if __name__ == "__main__":
    sys.exit(main())
