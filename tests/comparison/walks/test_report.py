"""The report on walks: self-contained, complete, true to the figures, plain about where the network does not help."""

import base64
import re
from html.parser import HTMLParser

import pytest

from footsel.comparison.report import Run
from footsel.comparison.walks import words
from footsel.comparison.walks.figures import figures
from footsel.comparison.walks.report import render, shown
from footsel.walking.courses import make_walk_course


def content(results):
    return {"robot": "anymal_b", "map": "exact", "watch_limbs": True, "seed": 0, "seeds": 10, **figures(results)}


@pytest.fixture
def page(traced):
    results = [each for each, _ in traced]
    courses = {(name, 0): make_walk_course(name, 0) for name in ("stairs", "stones")}
    return render(traced, courses, content(results), Run("footsel compare --walk stairs stones", 2, "a processor"))


class Page(HTMLParser):
    def __init__(self, html):
        super().__init__()
        self.terrains, self.loads, self._open = [], [], []
        self.feed(html)
        assert self._open == []

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag not in {"meta", "link", "img", "br"}:
            self._open.append(tag)
        self.loads += [values[key] for key in ("src", "href") if key in values]
        if "data-terrain" in values:
            self.terrains.append(values["data-terrain"])

    def handle_endtag(self, tag):
        assert self._open.pop() == tag


def test_it_is_whole_and_loads_nothing(page):
    parsed = Page(page)
    assert parsed.terrains == ["stairs", "stones"]
    assert all(load.startswith("data:") for load in parsed.loads)
    pictures = [load for load in parsed.loads if load.startswith("data:image/png;base64,")]
    assert len(pictures) == 2
    for picture in pictures:
        assert base64.b64decode(picture.split(",")[1]).startswith(b"\x89PNG")
    assert "footsel compare --walk stairs stones" in page


def test_rates_intervals_and_reasons_are_said(page):
    text = " ".join(re.sub(r"<[^>]+>", " ", page).split())
    assert "10.0 % 1.8 % … 40.4 %" in text
    assert "the base touched the ground" in text
    assert "seeds 0 to 9" in text


def test_words_name_where_the_network_helps_and_where_not(results):
    stairs, stones = words.where_the_network_helps(content(results))
    assert "On stairs the network does not help to reach the goal: cnn 10 of 10 and nominal 10 of 10." in stairs
    assert "hind shanks touch the ground, network minus others: nominal −0.65 s" in stairs
    assert "On stones the network reaches the goal more often than nominal: 10 of 10" in stones
    assert "against 1 of 10 (95 % interval 1.8 % to 40.4 %)" in stones


def test_few_walks_are_no_proof(results):
    few = [each for each in results if each.seed in (1, 2)]
    (_, stones) = words.where_the_network_helps(content(few))
    assert "may be chance" in stones


def test_words_name_the_worst_terrain_and_the_main_reason(results):
    about = words.about_selector("nominal", content(results))
    assert "11 of 20 walks" in about and "worst on stones: 1 of 10" in about
    assert "the base touched the ground (9 of 9)" in about
    assert words.about_selector("cnn", content(results)) == "cnn reached the goal in 20 of 20 walks."


def test_one_walk_per_terrain_is_drawn_the_networks(traced):
    assert [(each.terrain, each.selector, each.seed) for each, _ in shown(traced)] == [
        ("stairs", "cnn", 0),
        ("stones", "cnn", 0),
    ]
    others = [walk for walk in traced if walk[0].selector != "cnn"]
    assert [each.selector for each, _ in shown(others)] == ["oracle", "oracle"]
