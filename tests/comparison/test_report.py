"""The report: self-contained, complete, and true to the figures."""

import base64
import re
import struct
from html.parser import HTMLParser

import pytest

from footsel.comparison import summary
from footsel.comparison.examples import choose_examples
from footsel.comparison.report import Run, render

VOID = {"meta", "link", "img", "br"}


def png_size(content: bytes) -> tuple[int, int]:
    """Width and height in a PNG's header."""
    assert content[12:16] == b"IHDR"
    return struct.unpack(">II", content[16:24])


class Page(HTMLParser):
    """Collects what a browser would load, the rows, and whether every element is closed."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.loads: list[str] = []
        self.selectors: list[str] = []
        self._open: list[str] = []
        self.feed(html)
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        values = dict(attrs)
        self.loads += [values[key] or "" for key in ("src", "href", "srcset", "data") if key in values]
        self.selectors += [values["data-selector"] or ""] if "data-selector" in values else []
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, _: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag


@pytest.fixture(scope="module")
def html(comparison):
    return render(comparison, comparison.figures(), Run("footsel compare 'a <b>.npz' --out demo", 1, "A processor"))


def test_nothing_is_loaded_from_elsewhere(html):
    page = Page(html)
    assert page.loads
    assert all(load.startswith("data:") for load in page.loads)
    assert not {"script", "iframe", "object", "embed"} & set(page.tags)
    assert not re.search(r"https?:|@import|url\(", html)
    assert len(html) < 4e6


def test_every_selector_map_and_leg_is_there(html, comparison):
    page = Page(html)
    assert page.selectors == list(comparison.contestants.selectors)
    for text in ("stairs", "rubble", "LF", "RH", "false safe", "Glossary", "A processor", "recall"):
        assert text.lower() in html.lower()
    assert "&lt;b&gt;.npz" in html
    assert "<b>.npz" not in html


def test_each_example_has_six_panels_of_one_size(html, comparison):
    images = re.findall(r"data:image/png;base64,([\w+/=]+)", html)
    assert len(images) == 6 * len(choose_examples(comparison))
    assert len({png_size(base64.b64decode(image)) for image in images}) == 1


def test_the_summary_says_what_was_counted(html, comparison):
    figures = comparison.figures()
    picks = figures["selectors"]["cnn"]
    assert f"{picks['infeasible_picks']:,} of the {picks['picks']:,} picks of cnn" in html
    assert f"{figures['asked']} questions" in html
    assert summary.percent(picks["infeasible_rate"]) in html


def test_examples_show_what_went_wrong_and_every_map(comparison):
    examples = choose_examples(comparison)
    rejected, regretted = examples[0], examples[1]
    assert rejected.outcome.regrets["cnn"] == float("inf")
    finite = [
        outcome.regrets["cnn"]
        for verdict in comparison.verdicts
        for outcome in verdict.outcomes
        if outcome.regrets["cnn"] not in (None, float("inf"))
    ]
    assert regretted.outcome.regrets["cnn"] == max(finite)
    assert {example.map.name for example in examples if example.why == "Typical"} == {"stairs", "rubble"}


@pytest.mark.parametrize(
    ("share", "text"), [(None, "–"), (0.0, "0 %"), (1.0, "100 %"), (0.0042, "0.42 %"), (0.1234, "12.3 %")]
)
def test_shares_in_words(share, text):
    assert summary.percent(share) == text


def test_maps_of_one_name_keep_their_folders():
    assert summary.short_names(["a/x.npz", "b/x.npz", "b/y.npz"]) == {
        "a/x.npz": "a/x.npz",
        "b/x.npz": "b/x.npz",
        "b/y.npz": "y.npz",
    }
