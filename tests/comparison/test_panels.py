"""The drawings: orientation, colours, and no trace in matplotlib's global state."""

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from footsel.comparison import palette, panels
from footsel.footholds import BasePose, Reason
from footsel.oracle import Oracle
from footsel.selectors import make_selector
from footsel.terrain import LocalMap

PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def local_map(maps):
    layout = Oracle.load("anymal_b").robot.layout
    return layout.local_map(maps[0].elevation_map, BasePose(5.0, -2.0, 0.6, yaw=0.4), "LF")


@pytest.fixture(scope="module")
def label(local_map):
    return Oracle.load("anymal_b").label(local_map, "LF")


def shown_colour(axes, x, y):
    """Colour of the picture at a point of the heading frame."""
    image = axes.get_images()[0]
    left, right, bottom, top = image.get_extent()
    pixels = np.asarray(image.get_array())
    return pixels[int((x - bottom) / (top - bottom) * 40), int((y - left) / (right - left) * 40)]


def test_x_is_up_and_y_is_left():
    heights = np.zeros((40, 40), dtype=np.float32)
    local_map = LocalMap(heights, 0.02, np.zeros(3), 0.0)
    feasible = np.zeros((40, 40), dtype=bool)
    feasible[30:, 35:] = True  # ahead and to the left
    axes = panels.panel_figure()[1]
    panels.draw_cost(axes, local_map, np.zeros((40, 40)), feasible)
    assert axes.get_xlim() == (0.4, -0.4)
    assert axes.get_ylim() == (-0.4, 0.4)
    np.testing.assert_allclose(shown_colour(axes, 0.35, -0.35), to_rgba(palette.INFEASIBLE))
    assert not np.allclose(shown_colour(axes, 0.35, 0.35), to_rgba(palette.INFEASIBLE))


def test_marks_stand_in_their_cells(local_map):
    axes = panels.panel_figure()[1]
    panels.show_cells(axes, local_map, np.zeros((40, 40, 3)))
    panels.mark_picks(axes, local_map, {"oracle": (39, 0), "cnn": None})
    assert len(axes.lines) == 1
    (y,), (x,) = axes.lines[0].get_data()
    assert (x, y) == pytest.approx((0.39, -0.39))
    cell = local_map.positions()[39, 0, :2]
    np.testing.assert_allclose(panels.in_heading(local_map, cell), (x, y), atol=1e-9)


def test_disagreements_have_their_own_colours(local_map, label):
    axes = panels.panel_figure()[1]
    panels.draw_difference(axes, local_map, label.cost, ~label.feasible & local_map.known, label)
    shown = np.asarray(axes.get_images()[0].get_array())
    forbidden = local_map.known & ~label.feasible
    np.testing.assert_allclose(shown[forbidden], [to_rgba(palette.FALSE_SAFE)] * int(forbidden.sum()))
    np.testing.assert_allclose(shown[label.feasible], [to_rgba(palette.FALSE_UNSAFE)] * int(label.feasible.sum()))
    unknown = label.reason == Reason.UNKNOWN
    assert unknown.any()
    np.testing.assert_allclose(shown[unknown], [to_rgba(palette.UNKNOWN)] * int(unknown.sum()))


def test_figures_are_written_whole(tmp_path, maps, local_map, label):
    oracle = make_selector("oracle")
    pose = BasePose(5.0, -2.0, 0.6, yaw=0.4)
    panels.save_png(panels.label_figure(label, local_map, "LF"), tmp_path / "label.png")
    footholds = oracle.select(maps[0].elevation_map, pose, top_k=3)
    panels.draw_selection(tmp_path / "selection.png", maps[0].elevation_map, pose, oracle.layout, footholds)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["label.png", "selection.png"]
    for path in tmp_path.iterdir():
        content = path.read_bytes()
        assert content.startswith(PNG)
        assert len(content) > 5000


def test_a_map_of_unknown_cells_is_drawn_too():
    nothing = LocalMap(np.full((40, 40), np.nan), 0.02, np.zeros(3), 0.0)
    label = Oracle.load("anymal_b").label(nothing, "LF")
    assert panels.png_bytes(panels.label_figure(label, nothing, "LF")).startswith(PNG)
