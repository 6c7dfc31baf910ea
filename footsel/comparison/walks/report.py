"""The report on walks: one self-contained HTML file, pictures inside."""

import base64
from collections.abc import Mapping, Sequence
from typing import Any

from footsel.comparison import palette, panels, summary
from footsel.comparison.report import DESCRIPTIONS, Run, make_environment
from footsel.comparison.walks import words
from footsel.comparison.walks.drawing import walk_figure
from footsel.comparison.walks.figures import COMPARED, METRICS, NETWORK, REFERENCE
from footsel.legs import LEGS
from footsel.walking.course import WalkCourse
from footsel.walking.result import WalkResult
from footsel.walking.runs.trace import Trace

#: Name in walks.json -> heading, digits.
COLUMNS = {
    "distance_m": ("distance [m]", 2),
    "duration_s": ("time [s]", 0),
    "steps": ("steps", 0),
    "slip_mean_mm": ("mean slip [mm]", 1),
    "slip_max_mm": ("worst slip [mm]", 0),
    "shank_impacts": ("hard shank impacts", 2),
    "hind_shank_contact_s": ("hind shanks touch [s]", 2),
    "tracking_error_mm": ("tracking error [mm]", 0),
    "min_stability_margin_m": ("least stability margin [m]", 3),
    "realtime_factor": ("times real time", 1),
}


def render(
    walks: Sequence[tuple[WalkResult, Trace]],
    courses: Mapping[tuple[str, int], WalkCourse],
    figures: Mapping[str, Any],
    run: Run,
) -> str:
    """The HTML of `report.html`.

    courses: by terrain and seed, of the walks that are drawn. figures: the content of `walks.json`.
    """
    terrains = list(figures["summary"])
    selectors = list(dict.fromkeys(run["selector"] for run in figures["runs"]))
    reasons = list(dict.fromkeys(r for t in terrains for s in figures["summary"][t].values() for r in s["failures"]))
    return (
        make_environment()
        .get_template("walks.html.j2")
        .render(
            figures=figures,
            run=run.to_dict(),
            terrains=terrains,
            selectors=selectors,
            network=NETWORK,
            reference=REFERENCE,
            opening=words.opening(figures),
            paragraphs=[words.about_selector(name, figures) for name in selectors],
            network_minus=lambda terrain: figures["network_minus"].get(terrain, {}),
            minus_reference=lambda terrain: _minus_reference(figures["summary"][terrain]),
            network_worth=words.where_the_network_helps(figures),
            short_names=summary.short_names(terrains),
            descriptions=DESCRIPTIONS,
            columns={metric: COLUMNS[metric] for metric in METRICS},
            compared={metric: COLUMNS[metric] for metric in COMPARED},
            reasons=reasons,
            pictures=[_picture(result, trace, courses[result.terrain, result.seed]) for result, trace in shown(walks)],
            leg_colours={leg: palette.LEG_COLOURS[leg] for leg in LEGS},
        )
    )


def shown(walks: Sequence[tuple[WalkResult, Trace]]) -> list[tuple[WalkResult, Trace]]:
    """One walk per terrain to draw: the network's, if it walked there, with the first seed."""
    chosen: dict[str, tuple[WalkResult, Trace]] = {}
    for walk in walks:
        before = chosen.get(walk[0].terrain)
        if before is None or (walk[0].selector == NETWORK and before[0].selector != NETWORK):
            chosen[walk[0].terrain] = walk
    return list(chosen.values())


def _minus_reference(summaries: Mapping[str, Any]) -> dict[str, Any]:
    key = f"minus_{REFERENCE}"
    return {name: part[key] for name, part in summaries.items() if key in part}


def _picture(result: WalkResult, trace: Trace, course: WalkCourse) -> dict[str, Any]:
    content = panels.png_bytes(walk_figure(course, trace), dpi=120)
    return {"result": result, "image": "data:image/png;base64," + base64.b64encode(content).decode("ascii")}
