"""The model card: what the networks are, what exactly was run, how good they are, their limits, how to remake them."""

from collections.abc import Mapping
from typing import Any

from footsel.exporting import card_figures
from footsel.exporting.card_commands import commands
from footsel.exporting.card_figures import table
from footsel.learning.threshold import MOST_INFEASIBLE_PICKS, MOST_MISSED
from footsel.legs import PAIRS, TRAINED_LEG


def model_card(
    infos: Mapping[str, Mapping[str, Any]], parity: Mapping[str, Mapping[str, Any]], sizes: Mapping[str, int]
) -> str:
    """Markdown text of model_card.md.

    infos: pair -> header of the trained model (footsel.learning.checkpoint). parity: pair -> variant -> report.
    sizes: network file -> bytes.
    """
    robot = infos["front"]["robot"]
    return "\n".join(
        [
            f"# Foothold networks for {robot}",
            "",
            "For every cell of a 40x40 local map under a leg, the cost of stepping there in thirteen classes, or that",
            "the cell is not feasible: out of kinematic range, in self-collision, in collision with terrain. One",
            "network serves the front legs, one the hind legs; each was trained for the left leg, the right one is",
            f"mirrored. The architecture is {_ARCHITECTURES[infos['front']['recipe'].get('architecture', 'erfnet')]}.",
            "",
            "Made for `footsel.runtime.FootholdSelector`; all that it needs of the robot is in the files' metadata.",
            "",
            *_section("Files", _files(sizes)),
            *_section("What was run", _training(infos)),
            *_section("Validation", _validation(infos)),
            *_section("The files against the trained network", _parity(parity)),
            *_section("Limits", _limits(infos)),
            *_section("Remake it", commands(infos, int8=any("int8" in reports for reports in parity.values()))),
        ]
    )


_ARCHITECTURES = {
    "erfnet": "ERFNet, after Belter et al., ICRA 2019",
    "footnet": "FootNet: fixed layers for what the label depends on, learnt layers on each cell",
}


def _section(title: str, lines: list[str]) -> list[str]:
    return [f"## {title}", "", *lines, ""]


def _files(sizes: Mapping[str, int]) -> list[str]:
    rows = [(f"`{name}`", f"{size / 1e6:.2f} MB") for name, size in sorted(sizes.items())]
    rows += [
        ("`metrics.json`", "figures of the validation maps"),
        ("`parity.json`", "the files against the trained networks"),
        ("`SHA256SUMS`", "`sha256sum -c SHA256SUMS` checks the folder, as the loader does"),
    ]
    return table(("file", "content"), rows)


def _training(infos: Mapping[str, Mapping[str, Any]]) -> list[str]:
    def row(name: str, value: Any) -> tuple[str, ...]:
        return (name, *(str(value(infos[pair])) for pair in PAIRS))

    keys = [key for key in infos["front"]["recipe"] if key not in ("name", "epochs")]
    rows = [
        row("trained leg", lambda info: TRAINED_LEG[info["pair"]]),
        row("recipe", lambda info: info["recipe"]["name"]),
        row("training maps", lambda info: info["maps"]["training"]),
        row("validation maps", lambda info: info["maps"]["validation"]),
        row("data set SHA-256", lambda info: f"`{info['dataset_sha256'][:16]}…`"),
        row("began with", lambda info: _began_with(info.get("started_from"))),
        row("epochs", lambda info: f"{info['epochs_done']} of {info['recipe']['epochs']}"),
        row("seed", lambda info: info["seed"]),
        row("cell feasible if p(infeasible) <", lambda info: info["feasible_below"]),
        row("footsel", lambda info: info["version"]),
        *(row(f"recipe: {key}", lambda info, key=key: _plain(info["recipe"].get(key))) for key in keys),
    ]
    return table(("", *PAIRS), rows)


def _began_with(release: Mapping[str, str] | None) -> str:
    if release is None:
        return "random weights"
    return f"release `{release['sha256'][:16]}…`, trained on data set `{release['dataset_sha256'][:16]}…`"


def _plain(value: Any) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(map(str, value))
    return "-" if value is None else str(value)


def _validation(infos: Mapping[str, Mapping[str, Any]]) -> list[str]:
    figures = {pair: infos[pair]["validation"] for pair in PAIRS}
    lines = [
        "On the data set's validation maps, from courses that training never saw, of the same terrain families.",
        "The full set of figures is in `metrics.json`.",
        "",
        *card_figures.overall(figures),
    ]
    for pair in PAIRS:
        lines += ["", f"### Terrain families, {pair}", "", *card_figures.by_family(figures[pair])]
    for pair in PAIRS:
        lines += ["", f"### Thresholds, {pair}", ""]
        lines += card_figures.along_thresholds(figures[pair], infos[pair]["feasible_below"])
    return [
        *lines,
        "",
        "In bold the threshold, chosen on these maps to keep best to two limits, of which the worse counts: at most",
        f"{MOST_INFEASIBLE_PICKS:.1%} of the picks infeasible, at most {MOST_MISSED:.0%} of the footholds missed.",
        "Infeasible is a share of the picks; false safe and false unsafe are shares of cells.",
        "",
        "### Confidence",
        "",
        "A pick's confidence is 1 - p(infeasible) of its cell. A choice goes to where the network errs, so of the",
        "picks fewer are accepted than of all cells with that confidence.",
        "",
        *card_figures.confidences(figures),
    ]


def _parity(parity: Mapping[str, Mapping[str, Any]]) -> list[str]:
    head = ["network", "variant", "engine", "maps", "largest logit difference", "cells beyond 1e-4"]
    head += ["cells of another class", "of them no tie"]
    rows = []
    for pair, reports in parity.items():
        for variant, report in reports.items():
            engines = {"onnxruntime": report, **report.get("other_engines", {})}
            rows += [(pair, variant, name, *_differences(figures)) for name, figures in engines.items()]
    decoding = [
        max((report[key] for reports in parity.values() for report in reports.values()), default=0.0)
        for key in ("max_infeasible_difference", "max_cost_difference")
    ]
    return [
        "The trained network in torch beside the file, in onnxruntime and in other engines. Two classes within 2e-4 of",
        "each other are a tie.",
        "",
        *table(head, rows),
        "",
        f"The files' own decoding differs from numpy's of the same logits by up to {decoding[0]:.2g} in p(infeasible)",
        f"and {decoding[1]:.2g} in cost.",
    ]


def _differences(figures: Mapping[str, Any]) -> tuple[str, ...]:
    beyond = figures.get("cells_beyond_tolerance")
    return (
        f"{figures['maps']:,}",
        f"{figures['max_logit_difference']:.2g}",
        "-" if beyond is None else f"{beyond:,} of {figures['cells']:,}",
        f"{figures['class_differs']:,}",
        f"{figures['class_differs_beyond_ties']:,}",
    )


def _limits(infos: Mapping[str, Mapping[str, Any]]) -> list[str]:
    front = infos["front"]
    layout, planes = front["layout"], front["encoding"]["planes"]
    noise, holes = (front["recipe"].get(key, 0.0) for key in ("noise", "holes"))
    lines = [
        f"- One robot: {front['robot']}, cells of {layout['resolution'] * 100:g} cm, terrain down to "
        f"{layout['height_range']:g} m below the hip point. Deeper ground looks like ground at that depth.",
        f"- Trained on generated terrain with labels of the true ground; {noise:.0%} of the maps had a depth camera's",
        f"  noise and drift, {holes:.0%} had cells hidden.",
        "- A network errs: see the picks that the oracle rejects. Where a wrong step is costly, let an exact check",
        "  confirm the pick (`select(..., verify=...)`).",
        "- It judges where a foot stands, not how it gets there: the swing is for the planner to check.",
        *card_figures.weak_spots({pair: infos[pair]["validation"] for pair in PAIRS}),
    ]
    if "unknown" not in planes:
        lines.append("- Unknown cells look like the deepest ground to this network. They are never picked.")
    if "roll" not in planes:
        lines.append("- The network does not see the base's tilt.")
    return lines
