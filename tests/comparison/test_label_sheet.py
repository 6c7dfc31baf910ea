"""The sheet of one label: colours that tell which bodies meet."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from footsel.comparison import palette, panels
from footsel.comparison.label_sheet import NAMED_PAIRS, contact_colours, draw_contacts, draw_label_sheet, label_sheet
from footsel.footholds import Reason
from footsel.oracle import Oracle
from footsel.oracle.explanation import Contacts, LegExplainer
from footsel.terrain import LocalMap


@pytest.fixture(scope="module")
def walled():
    """A wall that the thigh cannot pass, in front of a low base."""
    heights = np.full((40, 40), -0.35)
    heights[26:29] = -0.05
    return LocalMap(heights, 0.02, np.zeros(3), 0.0)


@pytest.fixture(scope="module")
def label(walled):
    return Oracle.load().label(walled, "LF")


@pytest.fixture(scope="module")
def contacts(walled, label):
    return LegExplainer(Oracle.load().robot, "LF").contacts(label, walled, 0.0, 0.0)


def test_cells_have_the_colour_of_their_pair(walled, label, contacts):
    axes = panels.panel_figure()[1]
    draw_contacts(axes, walled, label, contacts)
    shown = np.asarray(axes.get_images()[0].get_array())
    colours = contact_colours(contacts)
    assert len(set(colours.values())) == len(colours) >= 3
    for i, j in np.ndindex(40, 40):
        pair = contacts.between(i, j)
        if pair is None:
            expected = palette.FAINT_REASON_COLOURS[Reason(int(label.reason[i, j]))]
        else:
            expected = colours.get(pair, palette.OTHER_CONTACT)
            assert (expected in palette.TERRAIN_CONTACTS) == (pair[1] == "terrain" and pair in colours)
        np.testing.assert_allclose(shown[i, j], to_rgb(expected))


def test_rare_pairs_share_a_colour():
    names = ("", *(f"body {k}" for k in range(1, 15)), "terrain")
    touching = np.zeros((40, 40, 2), dtype=np.uint8)
    for k in range(1, 15):
        touching[k, : 20 - k] = (k, 15)
    colours = contact_colours(Contacts(names, touching))
    assert list(colours) == [(f"body {k}", "terrain") for k in range(1, NAMED_PAIRS + 1)]


def test_the_key_counts_the_cells(walled, label, contacts):
    figure = label_sheet(label, contacts, walled, "LF")
    words = [text.get_text() for axes in figure.axes for each in axes.artists for text in getattr(each, "texts", [])]
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert len(titles) == 9 and "bodies that meet" in titles
    for (swing, other), count in list(contacts.pairs().items())[:NAMED_PAIRS]:
        assert f"{swing} against {other}: {count}" in words


def test_the_longest_names_fit_on_the_sheet(walled, label):
    names = tuple(f"{leg}_ADAPTER_0" for leg in ("LF", "RF"))
    touching = np.zeros((40, 40, 2), dtype=np.uint8)
    touching[:] = (1, 2)
    figure = label_sheet(label, Contacts(("", *names), touching), walled, "LF")
    figure.draw_without_rendering()
    keys = [each for axes in figure.axes for each in axes.artists if hasattr(each, "texts")]
    assert any("LF_ADAPTER_0 against RF_ADAPTER_0: 1600" in text.get_text() for key in keys for text in key.texts)
    for key in keys:
        assert key.get_window_extent().x1 <= figure.bbox.x1


def test_it_is_written_even_of_nothing(tmp_path):
    nothing = LocalMap(np.full((40, 40), np.nan), 0.02, np.zeros(3), 0.0)
    oracle = Oracle.load()
    label = oracle.label(nothing, "RF")
    contacts = LegExplainer(oracle.robot, "RF").contacts(label, nothing, 0.0, 0.0)
    draw_label_sheet(tmp_path / "label.png", label, contacts, nothing, "RF", np.zeros(2))
    assert [path.name for path in tmp_path.iterdir()] == ["label.png"]
