"""What fills our pages: tables from files, words and figures from commands."""

import json
import sys

import pytest

from footsel.legs import LEGS


@pytest.fixture
def tables(script, tmp_path, monkeypatch):
    """docs/update_tables.py with results of our own, in tmp_path."""
    module = script("update_tables")
    monkeypatch.setattr(module, "RESULTS", tmp_path)
    return module


def test_a_missing_file_is_said_in_its_place(tables):
    page = "<!-- value: v --><!-- end -->, <!-- table: t --><!-- end -->\n"
    filled = tables.fill("page", page, {"v": tables.pybullet, "t": tables.dataset_families})
    assert "<!-- value: v -->*not measured yet: `make verify-pybullet`*<!-- end -->" in filled
    assert "<!-- table: t -->\n*not measured yet: `python docs/measure_dataset.py`*\n<!-- end -->" in filled


def test_every_file_of_every_page_has_a_command(tables):
    """Nothing is there, and each place says what would make it."""
    for page, made in tables.PAGES.items():
        text = (tables.ROOT / page).read_text(encoding="utf-8")
        assert "not measured yet" in tables.fill(page, text, made) or page == "docs/terrain_cost.md"


def test_a_page_without_a_place_is_refused(tables):
    with pytest.raises(SystemExit, match="page has no place for v"):
        tables.fill("page", "nothing", {"v": tables.pybullet})


def test_bodies_of_four_legs_count_together(tables, tmp_path):
    rows = [
        {"kind": "self", "seen_by": "oracle", "bodies": f"{leg}_THIGH_0 against base_0", "cells": 2} for leg in LEGS
    ]
    rows.append({"kind": "self", "seen_by": "other", "bodies": "LF_FOOT mesh against RF_FOOT mesh", "cells": 3})
    (tmp_path / "verify_meshes.json").write_text(json.dumps({"by_bodies": rows}))
    assert tables.mesh_bodies().strip().splitlines()[2:] == [
        "| THIGH_0 against base_0 | primitives alone | 8 |",
        "| FOOT mesh against FOOT mesh | meshes alone | 3 |",
    ]


def test_contacts_are_put_into_words(tables, tmp_path):
    seen = {"neither": 80, "oracle_only": 1, "other_only": 2, "both": 1234}
    result = {"cells": 1317, "disagreements": 3, "largest_distance": 0.00196, "self": seen, "terrain": seen}
    (tmp_path / "verify_pybullet.json").write_text(json.dumps(result))
    assert tables.pybullet() == (
        "Of 1,317 cells in kinematic range 3 are judged differently, all within 2.0 mm of touching."
    )
    assert "| self collision | 1,234 | 1 | 2 | 80 |" in tables.contacts("verify_pybullet.json", "PyBullet")


def test_walks_are_summed_up(tables, tmp_path):
    def part(rate, **more):
        means = dict.fromkeys(tables.WALK_METRICS, 1.25)
        return {"n": 20, "success_rate": rate, "ci95": [rate / 2, rate], "means_of_successes": means, **more}

    difference = {"mean": -0.25, "ci95": [-0.5, -0.1], "sign_test_p": 0.01, "pairs": 9}
    result = {
        "summary": {
            "stairs": {"cnn": part(1.0), "nominal": part(0.0) | {"means_of_successes": None}},
            "maps/field.npz": {"cnn": part(0.5)},
        },
        "network_minus": {
            "stairs": {"nominal": {"success": difference, "shank_impacts": None, "hind_shank_contact_s": difference}}
        },
    }
    (tmp_path / "walks.json").write_text(json.dumps(result))
    assert tables.walks("walks.json").strip().splitlines()[2:] == [
        "| stairs | 20 | 100% (50–100) | 0% (0–0) |",
        "| field | 20 | 50% (25–50) | - |",
    ]
    assert [row.split("|")[1:4] for row in tables.walk_means("walks.json").strip().splitlines()[2:]] == [
        [" stairs ", " `cnn` ", " 20 "],
        [" field ", " `cnn` ", " 10 "],
    ]
    changed = "**−0.25** (−0.50 to −0.10)"
    assert f"| stairs | `nominal` | {changed} | - | {changed} |" in tables.walk_differences("walks.json")


def test_a_dataset_is_measured(script, tables, tmp_path, monkeypatch):
    measure = script("measure_dataset")
    monkeypatch.setattr(measure, "RESULT", tmp_path / "dataset.json")
    options = ["--maps", "4", "--legs", "front", "--families", "flat", "steps", "--jobs", "1"]
    monkeypatch.setattr(sys, "argv", ["measure_dataset.py", str(tmp_path / "data"), *options])
    assert measure.main() == 0
    result = json.loads((tmp_path / "dataset.json").read_text())
    manifest = json.loads((tmp_path / "data" / "manifest.json").read_text())
    assert result["families"] == manifest["families"] and result["config"]["maps"] == 4
    assert result["command"] == f"footsel dataset OUT {' '.join(options)}"
    assert result["seconds"] > 0.1 and 50 < result["peak_memory_mb"] < 5000
    assert tables.dataset().startswith(f"`{result['command']}`: 4 maps in ")
    rows = tables.dataset_families().strip().splitlines()[2:]
    assert [row.split("|")[1].strip() for row in rows] == ["all", *manifest["families"]]
    # A folder that is there already would tell another time.
    assert measure.main() == 2


def test_what_the_oracle_says_is_up_to_date(script, tmp_path):
    """If this fails, run python docs/make_figures.py and python docs/update_tables.py."""
    figures = script("make_figures")
    figures.draw_label(tmp_path / "label.png", tmp_path / "label.txt")
    written = (figures.DOCS / "results" / "label.txt").read_text(encoding="utf-8")
    assert (tmp_path / "label.txt").read_text(encoding="utf-8") == written


def test_figures_are_small(script):
    for path in (script("make_figures").DOCS / "figures").iterdir():
        assert path.stat().st_size < 150_000, path


@pytest.fixture
def bench(tmp_path):
    """A bench.json of round figures."""
    times = {"p50": 1.0, "p99": 2.0, "p999": 3.0}
    each = dict.fromkeys(("network_ms", "select_one_leg_ms", "select_four_legs_ms"), times)
    spread = {"counts": [0] * 25 + [60, 30, 0, 0, 10] + [0] * 70, **times, "max": 12.5}
    figures = {
        "cpu": "a CPU",
        "oracle_ms_per_map": {"p50": 1.5, "p99": 2.5},
        "models": {"float32": {**each, "other_core_busy": each}},
        "other_models": {"anymal_b_paper": each},
        "cpp": {"float32": {**each, "maps_per_second": {"1": 900.0, "64": 1500.0}}},
        "baselines": {"torch_eager": {"network_ms": {"p50": 9.0, "p99": 10.0}}},
        "maps_per_second": {"float32": {"one_core": {"1": 800.0, "64": 1234.0}}},
        "histogram": {
            "calls": 100,
            "edges_ms": [round(0.1 * 10 ** (n / 25), 4) for n in range(101)],
            "one_leg": {"other_core_idle": spread},
            "four_legs": {"other_core_idle": spread, "other_core_busy": spread},
        },
    }
    (tmp_path / "bench.json").write_text(json.dumps(figures))
    return figures


@pytest.mark.usefixtures("bench")
def test_latency_of_both_languages_and_of_others(tables):
    rows = tables.latency().strip().splitlines()
    assert rows[0] == "| ms on one core of a CPU | median | 99 % | 99.9 % |"
    assert "| `float32` in C++, four legs | 1.00 | 2.00 | 3.00 |" in rows
    assert "| `anymal_b_paper`, stock ERFNet, four legs | 1.00 | 2.00 | 3.00 |" in rows
    assert "| the same network in torch | 9.00 | 10.00 | - |" in rows
    assert sum("busy" in row for row in rows) == 1


@pytest.mark.usefixtures("bench")
def test_the_histogram_joins_bins_and_loses_no_call(tables):
    rows = [[cell.strip() for cell in row.strip("|").split("|")] for row in tables.histogram().strip().splitlines()]
    assert rows[0] == [
        "100 calls each",
        "one leg, other core idle",
        "four legs, other core idle",
        "four legs, other core busy",
    ]
    assert rows[2] == ["1 to 1.58 ms", "100", "100", "100"]
    assert rows[-1] == ["longest [ms]", "12.50", "12.50", "12.50"]


@pytest.mark.usefixtures("bench")
def test_maps_per_second_of_both_languages(tables):
    rows = tables.throughput().strip().splitlines()
    assert rows[2:] == ["| `float32`, one core | 800 | 1,234 |", "| `float32` in C++, one core | 900 | 1,500 |"]


def test_a_short_benchmark_leaves_the_long_tables_open(tables, bench, tmp_path):
    del bench["histogram"]
    (tmp_path / "bench.json").write_text(json.dumps(bench))
    page = tables.fill("page", "<!-- table: t --><!-- end -->", {"t": tables.histogram})
    assert "*not measured yet: `make bench-full`*" in page
