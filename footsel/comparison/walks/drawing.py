"""A walk from above and from the side."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from footsel.comparison import palette, panels
from footsel.legs import LEGS
from footsel.walking.course import WalkCourse
from footsel.walking.runs.trace import Trace

#: What is drawn beside the line that is walked, and the tracks of the feet that the side view shows. [m]
HALF_WIDTH, TRACK = 0.8, 0.25


def walk_figure(course: WalkCourse, trace: Trace) -> Figure:
    """The way from start to goal, left to right: chosen footholds and the base's path, above and beside the ground."""
    start, goal = np.array(course.start[:2]), np.array(course.goal)
    length = float(np.linalg.norm(goal - start))
    before, after = -0.6, length + 0.6
    figure = panels.new_figure(7.6, 3.9)
    above, beside = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [1.35, 1]})

    resolution = course.known.resolution
    along = np.arange(before, after, resolution)
    across = np.arange(-HALF_WIDTH, HALF_WIDTH, resolution)
    ground = _in_line(course, np.stack(np.meshgrid(along, across, indexing="ij"), axis=-1))
    above.imshow(
        panels.shaded(ground, resolution).transpose(1, 0, 2),
        origin="lower",
        extent=(before, after, -HALF_WIDTH, HALF_WIDTH),
        interpolation="nearest",
        aspect="auto",
    )
    for side in (TRACK, -TRACK):
        track = _in_line(course, np.stack([along, np.full(len(along), side)], axis=-1))
        beside.plot(along, track, color=palette.INK, linewidth=0.8, alpha=1.0 if side > 0 else 0.45)
    base = _to_line(course, trace.base)
    for axes, height in ((above, 1), (beside, 2)):
        axes.plot(base[:, 0], base[:, height], color=palette.INK, linewidth=1.1, linestyle="--", label="base")
        for leg in LEGS:
            points = _to_line(course, [point for name, point in trace.footholds if name == leg])
            axes.plot(
                points[:, 0],
                points[:, height],
                linestyle="none",
                marker="o",
                markersize=3.6,
                markeredgecolor="white",
                markeredgewidth=0.5,
                color=palette.LEG_COLOURS[leg],
                label=leg,
            )
    for place in (0.0, length):
        above.axvline(place, color=palette.INK, linewidth=0.7, linestyle=":")
    if trace.none:
        points = _to_line(course, [point for _, point in trace.none])
        above.plot(points[:, 0], points[:, 1], "x", color=palette.FALSE_SAFE, markersize=5, label='"none"')
    above.set_ylabel("left [m]", fontsize=panels.TEXT_SIZE)
    beside.set_ylabel("height [m]", fontsize=panels.TEXT_SIZE)
    beside.set_xlabel("way from the start [m]", fontsize=panels.TEXT_SIZE)
    for axes in (above, beside):
        axes.set_xlim(before, after)
        axes.tick_params(labelsize=panels.TEXT_SIZE)
    above.legend(loc="upper center", bbox_to_anchor=(0.5, 1.22), ncols=6, fontsize=panels.TEXT_SIZE, frameon=False)
    return figure


def _in_line(course: WalkCourse, points: NDArray[np.float64]) -> NDArray[np.float32]:
    """Known heights at (..., 2) points along and beside the line, relative to the ground under the start, in [m]."""
    c, s = np.cos(course.start[2]), np.sin(course.start[2])
    xy = np.array(course.start[:2]) + points @ np.array([[c, s], [-s, c]])
    return course.known.sample(xy) - course.known.sample(course.start[:2])


def _to_line(course: WalkCourse, points: "list[tuple[float, float, float]]") -> NDArray[np.float64]:
    """(k, 3) along, beside and above, of world points."""
    offset = np.array(points, dtype=np.float64).reshape(-1, 3)
    offset = offset - [*course.start[:2], float(course.known.sample(course.start[:2]))]
    c, s = np.cos(course.start[2]), np.sin(course.start[2])
    return np.stack([c * offset[:, 0] + s * offset[:, 1], c * offset[:, 1] - s * offset[:, 0], offset[:, 2]], axis=1)
