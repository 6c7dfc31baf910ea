"""What `footsel evaluate` found, on one sheet: is a probability to be believed, what does a threshold cost, what is
called what, and where is it worst."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.comparison import palette, panels
from footsel.errors import MissingExtraError
from footsel.footholds import Reason
from footsel.learning.threshold import MOST_INFEASIBLE_PICKS, MOST_MISSED

try:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
except ImportError as error:
    raise MissingExtraError("drawing", "report", error.name or "matplotlib") from None

ROW_INCHES = (14.4, 3.9)
#: Key of the figures, what it says, colour.
RELIABILITIES = (
    ("infeasible", "p(infeasible), cells", palette.LEG_COLOURS["LF"]),
    ("likeliest", "most probable class, cells", palette.LEG_COLOURS["LH"]),
    ("picks", "confidence of picks", palette.LEG_COLOURS["RF"]),
)
#: Fewer events than this say little of a frequency.
ENOUGH_EVENTS = 10
PROBABILITY_TICKS = (0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999)
NAMED_THRESHOLDS = (0.9, 0.5, 0.1, 0.01, 0.001)


def judgement_sheet(result: Mapping[str, Any]) -> Figure:
    """A row of four panels for each network of the figures that `footsel evaluate` writes."""
    networks = result["networks"]
    figure = panels.new_figure(ROW_INCHES[0], ROW_INCHES[1] * len(networks))
    grid = figure.subplots(len(networks), 4, squeeze=False, width_ratios=(1, 1.15, 0.95, 1.15))
    for axes, (name, figures) in zip(grid, networks.items(), strict=True):
        draw_reliability(axes[0], figures["all"]["calibration"])
        draw_thresholds(axes[1], figures["thresholds"], figures["feasible_below"])
        draw_confusion(axes[2], figures["all"])
        draw_families(axes[3], figures["families"])
        axes[0].set_title(f"{name}: probability and what came true", fontsize=panels.TITLE_SIZE)
    worse = result["degradation"]
    figure.supxlabel(
        f"{sum(figures['all']['maps'] for figures in networks.values()):,} maps, judged by the oracle"
        + (f"; input with noise {worse['noise']}, {worse['holes']:.0%} holes" if worse else ""),
        fontsize=panels.TEXT_SIZE,
        color=palette.NEUTRAL_INK,
    )
    return figure


def draw_judgement_sheet(path: Path, result: Mapping[str, Any]) -> None:
    """Write `judgement_sheet` as a PNG."""
    panels.save_png(judgement_sheet(result), path)


def draw_reliability(axes: Axes, calibration: Mapping[str, Mapping[str, Any]]) -> None:
    """Frequency against probability, both in log-odds, so that the ends show, where thresholds and most cells are."""
    ends = log_odds((PROBABILITY_TICKS[0] / 2, 1 - PROBABILITY_TICKS[0] / 2))
    axes.plot(ends, ends, color=palette.NEUTRAL_INK, linewidth=0.8, linestyle=":")
    for key, text, colour in RELIABILITIES:
        bins = [each for each in calibration[key]["bins"] if each["count"] >= ENOUGH_EVENTS]
        points = log_odds([(each["probability"], each["frequency"]) for each in bins]).reshape(-1, 2)
        ece = calibration[key]["ece"]
        label = text if ece is None else f"{text}: ECE {ece:.2%}"
        axes.plot(*np.clip(points, *ends).T, "o-", color=colour, markersize=3.2, linewidth=1.1, label=label)
    for along in (axes.xaxis, axes.yaxis):
        along.set_ticks(log_odds(PROBABILITY_TICKS), [f"{100 * each:g}" for each in PROBABILITY_TICKS])
    axes.set(xlim=ends, ylim=ends, aspect="equal")
    _name_axes(axes, "probability given [%]", "share that came true [%]")
    axes.legend(fontsize=panels.TEXT_SIZE - 1, frameon=False, loc="upper left", handlelength=1.2)


def draw_thresholds(axes: Axes, curve: Sequence[Mapping[str, Any]], chosen: float) -> None:
    """Infeasible picks against missed footholds along the thresholds, in the colour of the regret."""
    missed, infeasible, regret = (
        np.array([np.nan if point[key] is None else point[key] for point in curve], dtype=np.float64)
        for key in ("missed_rate", "infeasible_rate", "regret_mean")
    )
    axes.axvspan(0, 100 * MOST_MISSED, color=palette.REASON_COLOURS[Reason.FEASIBLE], alpha=0.3, linewidth=0)
    axes.axhspan(0, 100 * MOST_INFEASIBLE_PICKS, color=palette.REASON_COLOURS[Reason.FEASIBLE], alpha=0.3, linewidth=0)
    axes.plot(100 * missed, 100 * infeasible, color=palette.NEUTRAL_INK, linewidth=0.8, zorder=1)
    dots = axes.scatter(100 * missed, 100 * infeasible, c=regret, cmap=palette.COST_MAP, s=22, zorder=2, edgecolors="k")
    dots.set_linewidth(0.4)
    thresholds = np.array([point["feasible_below"] for point in curve])
    for named in NAMED_THRESHOLDS:
        at = int(np.abs(np.log(thresholds / named)).argmin())
        axes.annotate(
            f"p < {named:g}",
            (100 * missed[at], 100 * infeasible[at]),
            xytext=(6, 4),
            textcoords="offset points",
            fontsize=panels.TEXT_SIZE - 1,
        )
    # A network may come with a threshold between those of the curve.
    at = int(np.abs(np.log(thresholds / chosen)).argmin())
    axes.plot(100 * missed[at], 100 * infeasible[at], "o", markersize=10, fillstyle="none", color=palette.INK)
    # Linear up to what is asked, so that nothing missed at all can be shown too.
    axes.set_xscale("symlog", linthresh=100 * MOST_MISSED)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.set_xlim(-0.05, 2 * max(100 * float(missed.max(initial=0.0, where=np.isfinite(missed))), 1.0))
    axes.set_ylim(bottom=0)
    bar = axes.figure.colorbar(dots, ax=axes, pad=0.01, fraction=0.05)
    bar.set_label("mean regret of the picks", fontsize=panels.TEXT_SIZE)
    bar.ax.tick_params(labelsize=panels.TEXT_SIZE - 1)
    _name_axes(axes, "missed: no answer though there is one [% of maps]", "infeasible picks [%]")
    axes.set_title(f"thresholds; ringed: p(infeasible) < {chosen:.3g}", fontsize=panels.TITLE_SIZE)


def draw_confusion(axes: Axes, figures: Mapping[str, Any]) -> None:
    """What the cells of each reason are called, and the picks that went there."""
    cells, picks = figures["cells"], figures["picks"]
    reasons = [reason for reason in Reason if reason != Reason.UNKNOWN]
    recall = [cells["recall_by_reason"][reason.name] for reason in reasons]
    feasible = np.array(
        [
            np.nan if r is None else r if reason == Reason.FEASIBLE else 1 - r
            for r, reason in zip(recall, reasons, strict=True)
        ]
    )
    shares = np.stack([feasible, 1 - feasible], axis=1)
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1.3, aspect="auto")
    for (row, column), value in np.ndenumerate(shares):
        text = "-" if np.isnan(value) else f"{value:.2%}"
        axes.text(column, row, text, ha="center", va="center", fontsize=panels.TEXT_SIZE + 1)
    total = max(sum(cells["cells_by_reason"].values()), 1)
    rows = []
    for reason in reasons:
        share = cells["cells_by_reason"][reason.name] / total
        went = picks["picks"] - picks["infeasible_picks"]
        went = went if reason == Reason.FEASIBLE else picks["infeasible_by_reason"][reason.name]
        rows.append(f"{panels.reason_text(reason)}\n{share:.1%} of cells\n{went:,} picks")
    axes.set_yticks(range(len(rows)), rows, fontsize=panels.TEXT_SIZE)
    axes.set_xticks((0, 1), ("feasible", "infeasible"), fontsize=panels.TEXT_SIZE)
    axes.tick_params(length=0)
    axes.set_title("cells of a reason are called", fontsize=panels.TITLE_SIZE)


def draw_families(axes: Axes, families: Mapping[str, Mapping[str, Any]]) -> None:
    """Missed footholds and infeasible picks of each terrain family, the worst at the top."""

    def percent(name: str, key: str) -> float:
        return 100 * float(families[name]["picks"][key] or 0.0)

    names = sorted(families, key=lambda name: percent(name, "infeasible_rate") + percent(name, "missed_rate"))
    rows = np.arange(len(names))
    for shift, key, text, colour in (
        (0.2, "infeasible_rate", "infeasible picks", palette.FALSE_SAFE),
        (-0.2, "missed_rate", "missed", palette.FALSE_UNSAFE),
    ):
        axes.barh(rows + shift, [percent(name, key) for name in names], 0.38, color=colour, label=text)
    regrets = [families[name]["picks"]["regret_mean"] for name in names]
    texts = [
        f"{name} ({'-' if regret is None else format(regret, '.1f')})"
        for name, regret in zip(names, regrets, strict=True)
    ]
    axes.set_yticks(rows, texts, fontsize=panels.TEXT_SIZE)
    _name_axes(axes, "%", "")
    axes.legend(fontsize=panels.TEXT_SIZE - 1, frameon=False, loc="lower right", handlelength=1.0)
    axes.set_title("by terrain family (mean regret)", fontsize=panels.TITLE_SIZE)


def log_odds(probability: ArrayLike) -> NDArray[np.float64]:
    """ln(p / (1 - p)), infinite at 0 and 1."""
    p = np.asarray(probability, dtype=np.float64)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(p) - np.log1p(-p))


def _name_axes(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, fontsize=panels.TEXT_SIZE)
    axes.set_ylabel(y, fontsize=panels.TEXT_SIZE)
    axes.tick_params(labelsize=panels.TEXT_SIZE - 1)
