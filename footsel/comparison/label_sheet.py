"""One label on one sheet: why each cell is what it is, what it costs, and how the leg stands there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footsel.comparison import palette, panels
from footsel.errors import MissingExtraError
from footsel.footholds import Reason
from footsel.terrain import LocalMap

if TYPE_CHECKING:
    from footsel.oracle import Label
    from footsel.oracle.explanation import Contacts, Pair

try:
    from matplotlib.axes import Axes
    from matplotlib.colors import to_rgb
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend
    from matplotlib.patches import Patch
except ImportError as error:
    raise MissingExtraError("drawing", "report", error.name or "matplotlib") from None

#: Pairs of bodies that get a colour of their own; rarer ones share one.
NAMED_PAIRS = 8
SHEET_INCHES = (12.0, 7.9)


def label_sheet(
    label: Label, contacts: Contacts, local_map: LocalMap, leg: str, nominal_xy: NDArray[np.float64] | None = None
) -> Figure:
    """Nine panels: terrain, reasons and the bodies that meet; cost, margin and terrain cost; the three joint angles.

    nominal_xy: (2,) world xy of the nominal foothold, marked with a cross if given, in [m].
    """

    def values(array: NDArray[np.floating], colours: str, low: float, high: float | None) -> Callable[[Axes], None]:
        return lambda axes: panels.draw_values(axes, local_map, array, colours, low, high)

    def joint(index: int) -> Callable[[Axes], None]:
        angles = label.joint_angles[..., index]
        low, high = _angle_limits(angles)
        return values(angles, palette.ANGLE_MAP, low, high)

    drawings: list[tuple[str, Callable[[Axes], None]]] = [
        (f"terrain below {leg}'s hip [m]", lambda axes: panels.draw_terrain(axes, local_map)),
        ("first constraint that fails", lambda axes: panels.draw_reasons(axes, local_map, label.reason, legend=False)),
        ("bodies that meet", lambda axes: draw_contacts(axes, local_map, label, contacts)),
        ("cost", lambda axes: panels.draw_cost(axes, local_map, label.cost, label.feasible)),
        ("kinematic margin [m]", values(label.kinematic_margin, palette.MARGIN_MAP, 0.0, None)),
        ("terrain cost $c_m$", values(label.terrain_cost, palette.COST_MAP, 0.0, 1.0)),
        ("abduction HAA [rad]", joint(0)),
        ("hip flexion HFE [rad]", joint(1)),
        ("knee flexion KFE [rad]", joint(2)),
    ]
    figure = panels.new_figure(*SHEET_INCHES)
    figure.set_layout_engine("constrained", w_pad=0.06, h_pad=0.06)
    grid = figure.subplots(3, 4, width_ratios=(1.0, 1.0, 1.0, 0.98))
    for beside in grid[:, 3]:
        beside.set_axis_off()
    draw_key(grid[0, 3], label, contacts)
    for axes, (title, draw) in zip(grid[:, :3].flat, drawings, strict=True):
        draw(axes)
        axes.set_title(title, fontsize=panels.TITLE_SIZE)
        if nominal_xy is not None:
            panels.mark_point(axes, panels.in_heading(local_map, nominal_xy), palette.NOMINAL_POINT)
    figure.supxlabel(
        "seen from above, the robot's heading up; axes in metres from the point below the hip"
        + (", the cross is the nominal foothold" if nominal_xy is not None else ""),
        fontsize=panels.TEXT_SIZE,
        color=palette.NEUTRAL_INK,
    )
    return figure


def draw_label_sheet(
    path: Path,
    label: Label,
    contacts: Contacts,
    local_map: LocalMap,
    leg: str,
    nominal_xy: NDArray[np.float64] | None = None,
) -> None:
    """Write `label_sheet` as a PNG."""
    panels.save_png(label_sheet(label, contacts, local_map, leg, nominal_xy), path)


def draw_contacts(axes: Axes, local_map: LocalMap, label: Label, contacts: Contacts) -> None:
    """Colliding cells by the two bodies that meet there, terrain warm, the robot itself cold; others are faint."""
    image = np.array([to_rgb(palette.FAINT_REASON_COLOURS[each]) for each in Reason])[label.reason]
    colours = contact_colours(contacts)
    for i, j in np.argwhere(contacts.touching[..., 0]).tolist():
        pair = contacts.between(i, j)
        image[i, j] = to_rgb(colours.get(pair, palette.OTHER_CONTACT) if pair else palette.OTHER_CONTACT)
    panels.show_cells(axes, local_map, image)


def draw_key(axes: Axes, label: Label, contacts: Contacts) -> None:
    """What the colours of reasons and contacts mean, and how many cells each pair decides."""
    present = [each for each in Reason if (label.reason == each).any()]
    reasons = [Patch(color=palette.REASON_COLOURS[each], label=panels.reason_text(each)) for each in present]
    axes.add_artist(_legend(axes, reasons, "first constraint that fails", 1.04))
    found, colours = contacts.pairs(), contact_colours(contacts)
    met = [Patch(color=colour, label=f"{pair[0]} against {pair[1]}: {found[pair]}") for pair, colour in colours.items()]
    others = sum(count for pair, count in found.items() if pair not in colours)
    if others:
        met.append(Patch(color=palette.OTHER_CONTACT, label=f"other pairs: {others}"))
    if met:
        axes.add_artist(_legend(axes, met, "bodies that meet: cells", 0.98 - 0.085 * (len(present) + 1)))


def _legend(axes: Axes, handles: list[Patch], title: str, top: float) -> Legend:
    """A key at the left of the axes, its upper edge at a share of their height."""
    return Legend(
        axes,
        handles,
        [str(handle.get_label()) for handle in handles],
        loc="upper left",
        bbox_to_anchor=(-0.1, top),
        bbox_transform=axes.transAxes,
        title=title,
        alignment="left",
        fontsize=panels.TEXT_SIZE,
        title_fontsize=panels.TEXT_SIZE,
        frameon=False,
        handlelength=1.0,
    )


def contact_colours(contacts: Contacts) -> dict[Pair, str]:
    """A colour for each of the commonest pairs, the terrain's first."""
    from footsel.oracle.explanation import TERRAIN

    common = list(contacts.pairs())[:NAMED_PAIRS]
    with_terrain = [pair for pair in common if pair[1] == TERRAIN]
    with_itself = [pair for pair in common if pair[1] != TERRAIN]
    return dict(zip(with_terrain, palette.TERRAIN_CONTACTS, strict=False)) | dict(
        zip(with_itself, palette.SELF_CONTACTS, strict=False)
    )


def _angle_limits(angles: NDArray[np.floating]) -> tuple[float, float]:
    """Range of an angle's colours, at least a tenth of a radian."""
    there = angles[np.isfinite(angles)]
    if not there.size:
        return -0.05, 0.05
    low, high = float(there.min()), float(there.max())
    spread = max(0.1 - (high - low), 0.0) / 2
    return low - spread, high + spread
