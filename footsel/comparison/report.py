"""The report of a comparison: one self-contained HTML file, pictures inside."""

import base64
import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

import footsel
from footsel.comparison import palette, panels, summary
from footsel.comparison.compare import Comparison
from footsel.comparison.contestants import Contestants
from footsel.comparison.examples import Example, choose_examples, judged_selector
from footsel.errors import MissingExtraError
from footsel.footholds import Reason
from footsel.footholds.request import LegRequest, prepare
from footsel.oracle import Label

try:
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from matplotlib.axes import Axes
except ImportError as error:
    raise MissingExtraError("the report", "report", error.name or "Jinja2") from None

DESCRIPTIONS = {
    "oracle": "checks every cell exactly",
    "cnn": "the network alone",
    "cnn:int8": "the network's 8-bit variant alone",
    "cnn+verify": "the network's candidates, until the oracle accepts one",
    "terrain_only": "terrain shape and distance, no kinematics, no collisions",
    "nominal": "the nominal foothold, whatever lies there",
    "krotkov": "ground alone: inclination, roughness and curvature (Krotkov and Simmons 1996)",
    "chen_kumar": "ground alone: probability of support under uncertain heights (Chen and Kumar)",
    "barasuol": "ground alone: the nearest cell of acceptable pattern (Barasuol et al. 2015)",
    "rebula": "ground alone: no edges, steep slopes, cliffs or holes (Rebula et al. 2007)",
    "kolter": "ground alone: weighted features at four scales (Kolter et al. 2008)",
    "roennau": "ground alone: credibility, mean height and variance (Roennau et al. 2009)",
    "traversability": "ground alone: slope, step and roughness (Wermelinger et al. 2016)",
}
LIBRARIES = ("numpy", "onnxruntime", "pin", "coal", "numba")


@dataclass(frozen=True)
class Run:
    """How the figures came about.

    command: as typed. jobs: processes. cpu: name of the processor. libraries: those whose versions matter.
    """

    command: str
    jobs: int
    cpu: str
    libraries: tuple[str, ...] = LIBRARIES

    def to_dict(self) -> dict[str, Any]:
        """The entry `run` of `compare.json`."""
        versions = {"footsel": footsel.__version__, "python": platform.python_version()}
        for library in self.libraries:
            try:
                versions[library] = version(library)
            except PackageNotFoundError:
                continue
        return {"command": self.command, "jobs": self.jobs, "cpu": self.cpu, "versions": versions}


def make_environment() -> Environment:
    """Of the templates beside this package, with the filters that they use."""
    environment = Environment(
        loader=PackageLoader("footsel.comparison"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(percent=summary.percent, distance=summary.distance)
    return environment


def render(comparison: Comparison, figures: Mapping[str, Any], run: Run) -> str:
    """The HTML of `report.html`. figures: of `comparison.figures()`."""
    judged = judged_selector(comparison)
    return (
        make_environment()
        .get_template("report.html.j2")
        .render(
            figures=figures,
            run=run.to_dict(),
            judged=judged,
            scorer=comparison.contestants.scorer,
            opening=summary.opening(figures),
            paragraphs=[summary.about_selector(name, figures) for name in figures["selectors"] if name != "oracle"],
            weak_sides="" if judged is None else summary.weak_sides(judged, figures),
            about_time=summary.about_time(figures, run.jobs),
            descriptions=DESCRIPTIONS,
            short_names=summary.short_names(figures["maps"]),
            reasons={reason.name: panels.reason_text(reason) for reason in Reason},
            reason_colours={reason.name: palette.REASON_COLOURS[reason] for reason in Reason},
            what_fails=summary.WHAT_FAILS,
            marks=palette.MARKS,
            palette=palette,
            examples=[_example_entry(comparison.contestants, example) for example in choose_examples(comparison)],
        )
    )


def _example_entry(contestants: Contestants, example: Example) -> dict[str, Any]:
    """What the template says of an example: where, what each selector chose, and the panels."""
    pose, leg = example.outcome.pose, example.outcome.leg
    request = prepare(contestants.layout, example.map.elevation_map, pose, (leg,))[0]
    picks = {
        name: selector.select(example.map.elevation_map, pose, (leg,))[leg]
        for name, selector in contestants.selectors.items()
    }
    label = contestants.oracle.label(request.local_map, leg, pose.roll, pose.pitch)
    answers = [
        {
            "selector": name,
            "reason": None if foothold.cell is None else Reason(int(label.reason[foothold.cell])).name,
            "regret": example.outcome.regrets[name],
            "distance": foothold.distance_to_nominal,
            "why_none": foothold.reason,
        }
        for name, foothold in picks.items()
    ]
    cells = {name: foothold.cell for name, foothold in picks.items()}
    return {
        "why": example.why,
        "map": example.map.name,
        "leg": leg,
        "pose": pose,
        "answers": answers,
        "panels": [
            {"title": title, "image": _panel_image(draw, request, cells)}
            for title, draw in _drawings(contestants, request, label)
        ],
    }


def _drawings(contestants: Contestants, request: LegRequest, label: Label) -> list[tuple[str, Callable[[Axes], None]]]:
    """Titles and drawings in the order of the paper's figures."""
    local_map = request.local_map
    nominal_xy = np.array(request.nominal[:2])
    drawings: list[tuple[str, Callable[[Axes], None]]] = [
        ("terrain, height above the hip [m]", lambda axes: panels.draw_terrain(axes, local_map)),
        ("distance to the nominal foothold [m]", lambda axes: panels.draw_distance(axes, local_map, nominal_xy)),
    ]
    name = contestants.scorer
    if name is not None:
        scores = contestants.selectors[name].score(request)
        drawings.append(
            (f"cost by {name}", lambda axes: panels.draw_cost(axes, local_map, scores.cost, scores.feasible))
        )
    drawings.append(("cost by the oracle", lambda axes: panels.draw_cost(axes, local_map, label.cost, label.feasible)))
    if name is not None:
        drawings.append(
            (
                f"difference, {name} − oracle",
                lambda axes: panels.draw_difference(axes, local_map, scores.cost, scores.feasible, label),
            )
        )
    drawings.append(
        ("the oracle's reasons", lambda axes: panels.draw_reasons(axes, local_map, label.reason, legend=False))
    )
    return drawings


def _panel_image(draw: Callable[[Axes], None], request: LegRequest, cells: Mapping[str, tuple[int, int] | None]) -> str:
    """A drawing with all picks on it, as a data URI."""
    figure, axes = panels.panel_figure()
    draw(axes)
    panels.mark_point(axes, panels.in_heading(request.local_map, request.nominal[:2]), palette.NOMINAL_POINT)
    panels.mark_picks(axes, request.local_map, cells)
    panels.recolour(figure, palette.NEUTRAL_INK)
    return "data:image/png;base64," + base64.b64encode(panels.png_bytes(figure)).decode("ascii")
