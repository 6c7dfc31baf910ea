"""Drawings of local maps and footholds: the panels of the paper's figures, seen from above, the robot facing up.

Every function draws on axes that it is given or returns a figure of its own; matplotlib's global state is not touched.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footsel.comparison import palette
from footsel.errors import MissingExtraError
from footsel.files import replace_file
from footsel.footholds import BasePose, Foothold, LegLayout, Reason
from footsel.footholds.cost import INFEASIBLE_COST, MAX_FEASIBLE_COST
from footsel.footholds.pose import heading_rotation
from footsel.terrain import ElevationMap, LocalMap

if TYPE_CHECKING:
    # Footholds are drawn where no oracle is installed.
    from footsel.oracle import Label

try:
    from matplotlib import colormaps
    from matplotlib.axes import Axes
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Colormap, LightSource, LinearSegmentedColormap, Normalize, to_rgb, to_rgba
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch, Polygon
    from matplotlib.patheffects import withStroke
    from matplotlib.ticker import MaxNLocator
except ImportError as error:
    raise MissingExtraError("drawing", "report", error.name or "matplotlib") from None

TITLE_SIZE, TEXT_SIZE = 9.0, 7.0
#: Width leaves room for a scale beside a square drawing.
PANEL_INCHES = (3.05, 2.35)
#: Largest difference of cost that the colours tell apart.
DIFFERENCE_RANGE = 100.0
TERRAIN_MAP = LinearSegmentedColormap.from_list("terrain", palette.TERRAIN_COLOURS)


def label_figure(label: Label, local_map: LocalMap, leg: str, nominal_xy: NDArray[np.float64] | None = None) -> Figure:
    """What the oracle says of a local map: terrain, cost, reasons, kinematic margin and terrain cost.

    nominal_xy: (2,) world xy of the nominal foothold, marked with a cross if given, in [m].
    """
    drawings: list[tuple[str, Callable[[Axes], None]]] = [
        (f"terrain under {leg} [m]", lambda axes: draw_terrain(axes, local_map)),
        ("cost", lambda axes: draw_cost(axes, local_map, label.cost, label.feasible)),
        ("reason", lambda axes: draw_reasons(axes, local_map, label.reason)),
        (
            "kinematic margin [m]",
            lambda axes: draw_values(axes, local_map, label.kinematic_margin, palette.MARGIN_MAP, 0.0),
        ),
        (
            "terrain cost $c_m$",
            lambda axes: draw_values(axes, local_map, label.terrain_cost, palette.COST_MAP, 0.0, 1.0),
        ),
    ]
    figure = new_figure(2.55 * len(drawings), 2.75)
    for axes, (title, draw) in zip(np.atleast_1d(figure.subplots(1, len(drawings))), drawings, strict=True):
        draw(axes)
        axes.set_title(title, fontsize=TITLE_SIZE)
        if nominal_xy is not None:
            mark_point(axes, in_heading(local_map, nominal_xy), palette.NOMINAL_POINT)
    return figure


def selection_figure(
    elevation_map: ElevationMap,
    pose: BasePose,
    footholds: Mapping[str, Foothold],
    layout: LegLayout,
    reach: float = 1.0,
) -> Figure:
    """The map around the base from above, world x to the right: local maps, nominal footholds, picks, alternatives.

    reach: half the side of what is shown, in [m].
    """
    cells = 2 * int(np.ceil(reach / elevation_map.resolution)) + 1
    window = elevation_map.window(pose.position[:2], cells)
    figure = new_figure(6.4, 5.4)
    axes = figure.subplots()
    draw_map(axes, window)

    turn = heading_rotation(pose.yaw)[:2, :2]
    hips = {leg: layout.hip_position(leg, pose)[:2] for leg in layout.hips}
    body = np.array([hips[leg] for leg in ("LF", "RF", "RH", "LH")])
    axes.add_patch(Polygon(body, closed=True, fill=False, edgecolor=palette.INK, linewidth=1.6))
    ahead = (turn @ [float(np.abs(layout.hips["LF"][0])) + 0.12, 0.0]).tolist()
    axes.arrow(pose.x, pose.y, *ahead, head_width=0.035, length_includes_head=True, color=palette.INK, linewidth=1.2)
    corners = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]]) * layout.resolution * 20
    outline = [withStroke(linewidth=2.6, foreground="white")]
    for leg, foothold in footholds.items():
        colour = palette.LEG_COLOURS[leg]
        square = hips[leg] + corners @ turn.T
        axes.add_patch(Polygon(square, closed=True, fill=False, edgecolor=colour, linewidth=0.9, linestyle=":"))
        axes.plot(*foothold.nominal[:2], marker="+", color=colour, markersize=9, path_effects=outline)
        for alternative in foothold.alternatives:
            axes.plot(*alternative.position[:2], marker="o", color=colour, markersize=4, markeredgecolor="white")
        if foothold.position is not None:
            axes.plot(*foothold.position[:2], marker="o", color=colour, markersize=10, markeredgecolor="white")
        place = foothold.nominal if foothold.position is None else foothold.position
        text = leg if foothold.position is not None else f"{leg}: none"
        axes.annotate(
            text,
            place[:2],
            xytext=(8, 6),
            textcoords="offset points",
            color=colour,
            fontsize=TITLE_SIZE,
            fontweight="bold",
            path_effects=outline,
        )
    keys = [
        _key("o", 8, "chosen foothold"),
        _key("o", 4, "alternative"),
        _key("+", 8, "nominal foothold"),
        Line2D([], [], color=palette.NEUTRAL_INK, linestyle=":", label="local map of a leg"),
    ]
    figure.legend(handles=keys, loc="outside lower center", ncols=len(keys), fontsize=TEXT_SIZE, frameon=False)
    return figure


def draw_selection(
    path: Path, elevation_map: ElevationMap, pose: BasePose, layout: LegLayout, footholds: Mapping[str, Foothold]
) -> None:
    """Write `selection_figure` as a PNG."""
    save_png(selection_figure(elevation_map, pose, footholds, layout), path)


def draw_map(axes: Axes, elevation_map: ElevationMap) -> None:
    """A whole map, world x to the right and y up, heights lit from one side."""
    (x0, y0), (x1, y1) = (elevation_map.position + sign * np.array(elevation_map.size) / 2 for sign in (-1, 1))
    image = shaded(elevation_map.elevation, elevation_map.resolution)
    axes.imshow(image.transpose(1, 0, 2), origin="lower", extent=(x0, x1, y0, y1), interpolation="nearest")
    axes.set_autoscale_on(False)
    axes.set_xlabel("world x [m]", fontsize=TEXT_SIZE)
    axes.set_ylabel("world y [m]", fontsize=TEXT_SIZE)
    axes.tick_params(labelsize=TEXT_SIZE)
    _colour_bar(axes, _height_limits(elevation_map.elevation), TERRAIN_MAP, "height [m]")


def draw_terrain(axes: Axes, local_map: LocalMap) -> None:
    """Heights relative to the hip point, lit from one side."""
    show_cells(axes, local_map, shaded(local_map.heights, local_map.resolution))
    _colour_bar(axes, _height_limits(local_map.heights), TERRAIN_MAP)


def draw_distance(axes: Axes, local_map: LocalMap, nominal_xy: NDArray[np.float64]) -> None:
    """Distance d_n of known cells to the nominal foothold, a line every 10 cm."""
    distances = np.where(local_map.known, local_map.distances_to(nominal_xy), np.nan)
    draw_values(axes, local_map, distances, palette.DISTANCE_MAP, 0.0)
    half = local_map.cells * local_map.resolution / 2
    along = np.linspace(-half, half, 200)
    x, y = in_heading(local_map, nominal_xy)
    grid_y, grid_x = np.meshgrid(along, along)
    axes.contour(
        grid_y,
        grid_x,
        np.hypot(grid_x - x, grid_y - y),
        levels=np.arange(0.1, 2.0, 0.1),
        colors=[palette.INK],
        linewidths=0.5,
        alpha=0.6,
    )


def draw_cost(axes: Axes, local_map: LocalMap, cost: ArrayLike, feasible: NDArray[np.bool_]) -> None:
    """Cost of the feasible cells, the others in one colour."""
    cost = np.asarray(cost, dtype=np.float64)
    image = colormaps[palette.COST_MAP](np.clip(cost / INFEASIBLE_COST, 0, 1))
    image[~feasible] = to_rgba(palette.INFEASIBLE)
    image[~local_map.known] = to_rgba(palette.UNKNOWN)
    show_cells(axes, local_map, image)
    _colour_bar(axes, (0.0, MAX_FEASIBLE_COST), palette.COST_MAP)


def draw_difference(
    axes: Axes, local_map: LocalMap, cost: ArrayLike, feasible: NDArray[np.bool_], label: Label
) -> None:
    """A judgement's cost minus the oracle's where both allow a foot; where they disagree on that, who allows it."""
    difference = np.asarray(cost, dtype=np.float64) - label.cost
    image = colormaps[palette.DIFFERENCE_MAP](np.clip(difference / (2 * DIFFERENCE_RANGE) + 0.5, 0, 1))
    image[~feasible & ~label.feasible] = to_rgba(palette.INFEASIBLE)
    image[feasible & ~label.feasible] = to_rgba(palette.FALSE_SAFE)
    image[~feasible & label.feasible] = to_rgba(palette.FALSE_UNSAFE)
    image[~local_map.known] = to_rgba(palette.UNKNOWN)
    show_cells(axes, local_map, image)
    _colour_bar(axes, (-DIFFERENCE_RANGE, DIFFERENCE_RANGE), palette.DIFFERENCE_MAP)


def draw_reasons(axes: Axes, local_map: LocalMap, reason: NDArray[np.uint8], legend: bool = True) -> None:
    """Which constraint a cell fails first."""
    table = np.array([to_rgb(palette.REASON_COLOURS[each]) for each in Reason])
    show_cells(axes, local_map, table[reason])
    if legend:
        present = [each for each in Reason if (reason == each).any()]
        axes.legend(
            handles=[Patch(color=palette.REASON_COLOURS[each], label=reason_text(each)) for each in present],
            loc="upper center",
            bbox_to_anchor=(0.5, -0.1),
            ncols=2,
            fontsize=TEXT_SIZE - 1,
            frameon=False,
            handlelength=1.0,
        )


def draw_values(
    axes: Axes,
    local_map: LocalMap,
    values: NDArray[np.floating],
    colour_map: str,
    low: float,
    high: float | None = None,
) -> None:
    """A quantity of some cells; those without a value are drawn as infeasible, or as unknown."""
    there = np.isfinite(values)
    if high is None:
        high = float(values[there].max()) if there.any() else 1.0
    image = colormaps[colour_map](np.clip((np.where(there, values, low) - low) / max(high - low, 1e-9), 0, 1))
    image[~there] = to_rgba(palette.INFEASIBLE)
    image[~local_map.known] = to_rgba(palette.UNKNOWN)
    show_cells(axes, local_map, image)
    _colour_bar(axes, (low, high), colour_map)


def show_cells(axes: Axes, local_map: LocalMap, image: NDArray[np.floating]) -> None:
    """Show a picture (n, n, 3 or 4) of the cells in the heading frame: x up, y to the left, both from M_i in [m]."""
    half = local_map.cells * local_map.resolution / 2
    axes.imshow(image, origin="lower", extent=(-half, half, -half, half), interpolation="nearest")
    axes.set_xlim(half, -half)
    ticks = np.array([-0.75, 0.0, 0.75]) * half
    axes.set_xticks(ticks)
    axes.set_yticks(ticks)
    axes.tick_params(labelsize=TEXT_SIZE, length=2, color=palette.NEUTRAL_INK)


def mark_picks(axes: Axes, local_map: LocalMap, picks: Mapping[str, tuple[int, int] | None]) -> None:
    """Mark the cell that each selector chose, largest mark first, so that equal picks are nested."""
    middle = (local_map.cells - 1) / 2
    for name in sorted(picks, key=lambda name: -palette.MARKS[name].size):
        cell = picks[name]
        if cell is not None:
            mark_point(axes, (np.array(cell) - middle) * local_map.resolution, palette.MARKS[name])


def mark_point(axes: Axes, xy: NDArray[np.float64], mark: palette.Mark) -> None:
    """Draw a mark at a point (2,) of the heading frame, from M_i in [m]."""
    axes.plot(
        xy[1],
        xy[0],
        marker=mark.marker,
        markersize=mark.size,
        markerfacecolor="none",
        markeredgecolor=mark.colour,
        markeredgewidth=1.8,
        linestyle="none",
        path_effects=[withStroke(linewidth=3.4, foreground=palette.INK)],
        clip_on=False,
    )


def in_heading(local_map: LocalMap, xy: ArrayLike) -> NDArray[np.float64]:
    """(2,) a world point in the local map's heading frame, from M_i, in [m]."""
    return np.asarray(heading_rotation(-local_map.yaw)[:2, :2] @ (np.asarray(xy, dtype=np.float64) - local_map.hip[:2]))


def reason_text(reason: Reason) -> str:
    """A reason as a reader would write it."""
    return reason.name.lower().replace("_", " ")


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of this many inches, drawn without a display."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def panel_figure() -> tuple[Figure, Axes]:
    """A figure of one square drawing, of the same size and place whatever stands beside it, with no paper behind."""
    figure = Figure(figsize=PANEL_INCHES)
    FigureCanvasAgg(figure)
    figure.patch.set_alpha(0)
    width, height = PANEL_INCHES
    return figure, figure.add_axes((0.1, 0.08, 0.89 * height / width, 0.89))


def recolour(figure: Figure, ink: str) -> None:
    """Turn ticks and frames to one colour, for a page whose background is not known."""
    for axes in figure.findobj(Axes):
        axes.tick_params(colors=ink)
        for spine in axes.spines.values():
            spine.set_edgecolor(ink)
            spine.set_linewidth(0.6)


def png_bytes(figure: Figure, dpi: float = 150) -> bytes:
    """The figure as a PNG."""
    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi, metadata={"Software": None})
    return buffer.getvalue()


def save_png(figure: Figure, path: Path, dpi: float = 150) -> None:
    """Write the figure as a PNG; the file appears whole or not at all."""
    content = png_bytes(figure, dpi)
    replace_file(Path(path), lambda temporary: temporary.write_bytes(content))


def shaded(heights: NDArray[np.floating], resolution: float) -> NDArray[np.float64]:
    """(n, m, 4) grey by height, lit from one side, unknown cells in their own colour."""
    known = np.isfinite(heights)
    filled = np.where(known, heights, np.median(heights[known]) if known.any() else 0.0).astype(np.float64)
    low, high = _height_limits(heights)
    grey = TERRAIN_MAP(np.clip((filled - low) / (high - low), 0, 1))
    lit = LightSource(azdeg=315, altdeg=50).hillshade(filled, dx=resolution, dy=resolution)
    image = np.array(grey)
    image[..., :3] *= 0.65 + 0.35 * np.clip(lit, 0, 1)[..., None]
    image[~known] = to_rgba(palette.UNKNOWN)
    return image


def _height_limits(heights: NDArray[np.floating]) -> tuple[float, float]:
    """Range of the colours: the heights', and at least 10 cm, so that flat ground looks flat."""
    known = heights[np.isfinite(heights)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    spread = max(0.1 - (high - low), 0.0) / 2
    return low - spread, high + spread


def _colour_bar(axes: Axes, limits: tuple[float, float], colour_map: str | Colormap, text: str = "") -> None:
    """A scale beside the axes, which keep their size."""
    beside = axes.inset_axes((1.03, 0.0, 0.05, 1.0))
    bar = axes.figure.colorbar(ScalarMappable(Normalize(*limits), colour_map), cax=beside)
    bar.locator = MaxNLocator(5)
    bar.update_ticks()
    beside.tick_params(labelsize=TEXT_SIZE, length=2)
    bar.set_label(text, fontsize=TEXT_SIZE)


def _key(marker: str, size: float, text: str) -> Line2D:
    return Line2D([], [], marker=marker, markersize=size, color=palette.NEUTRAL_INK, linestyle="none", label=text)
