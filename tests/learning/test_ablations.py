"""The ablation table: rows differ by what the plan says, none is trained twice, one that was killed goes on."""

import json
import sys

import pytest

from footsel.dataset import open_dataset
from footsel.dataset.store import MANIFEST, pack_shard, pair_entry, record_shard, shard_path, write_shard
from footsel.errors import UnknownNameError
from footsel.files import write_json
from footsel.learning import train as training
from footsel.learning.checkpoint import load_network
from footsel.learning.recipe import Recipe

PLAN = """
recipe = "footsel"
legs = "front"
[base]
maps = 16
epochs = 2
scarcity = 2.0
[rows."base"]
[rows."smaller, no place"]
cells = [8, 8]
widths = [12, 16]
blocks = [1, 0, 1]
features = ["footing"]
[rows."fewer maps"]
maps = 8
epochs = 3
"""
NAMES = ["base", "smaller, no place", "fewer maps"]
OTHER_DATA = """
[rows."of another dataset"]
data = "other"
"""


@pytest.fixture(scope="module")
def datasets(tmp_path_factory, make_samples):
    root = tmp_path_factory.mktemp("datasets")
    for seed, name in enumerate(("data", "test", "other")):
        for number in range(3):
            write_shard(shard_path(root / name, "front", number), pack_shard(make_samples(8, 10 * seed + number)))
        entry = pair_entry([record_shard(root / name, "front", number) for number in range(3)])
        config = {"robot": "anymal_b", "maps": 24, "seed": seed}
        write_json(root / name / MANIFEST, {"config": config, "pairs": {"front": entry}})
    return root


@pytest.fixture
def ablations(script, tmp_path, monkeypatch, datasets):
    """docs/ablations.py with a tiny plan; `command(*options)` runs it, `result` is its file."""
    module = script("ablations")
    (tmp_path / "ablations.toml").write_text(PLAN)
    monkeypatch.setattr(module, "DOCS", tmp_path)
    monkeypatch.setattr(module, "RESULT", tmp_path / "ablations.json")

    def command(*options, data="data", test="test"):
        arguments = [str(datasets / data), str(datasets / test), str(tmp_path / "work"), *options]
        monkeypatch.setattr(sys, "argv", ["ablations.py", *arguments])
        return module.main()

    module.command = command
    return module


def rows_of(ablations):
    return json.loads(ablations.RESULT.read_text())["rows"]


def trained(monkeypatch):
    """How many maps each update learnt from, as trainings run."""
    seen, update = [], training.Learner.update

    def counted(self, samples, *args, **kwargs):
        seen.append(len(samples))
        return update(self, samples, *args, **kwargs)

    monkeypatch.setattr(training.Learner, "update", counted)
    return seen


def test_rows_are_what_the_plan_says_and_fill_the_page(ablations, script, tmp_path, monkeypatch):
    seen = trained(monkeypatch)
    assert ablations.command() == 0
    assert seen == [16, 16, 16, 16, 8, 8, 8]
    rows = rows_of(ablations)
    assert [row["name"] for row in rows] == NAMES
    assert [(row["maps"], row["epochs"]) for row in rows] == [(16, 2), (16, 2), (8, 3)]
    assert rows[1]["parameters"] < rows[0]["parameters"] == rows[2]["parameters"]
    assert rows[1]["changes"]["features"] == ["footing"]
    for row in rows:
        assert row["picks"]["picks"] + row["picks"]["none"] == 24  # All maps of the other dataset.
        assert len({len(points) for points in row["thresholds"].values()}) == 1
        assert list(row["at_missed"]) == ["0.01", "0.02", "0.05"]

    tables = script("update_tables")
    monkeypatch.setattr(tables, "RESULTS", tmp_path)
    for made in (tables.ablations_picks(), tables.ablations_cells()):
        assert [line.split("|")[1].strip() for line in made.strip().splitlines()[2:]] == NAMES
    assert tables.ablations_conditions().startswith("16 maps for 2 epochs")

    # Done is done, and a model that has changed since is judged again.
    before = ablations.RESULT.read_text()
    assert ablations.command() == 0 and len(seen) == 7 and ablations.RESULT.read_text() == before


class KilledError(Exception):
    pass


def test_a_row_that_is_killed_goes_on(ablations, monkeypatch):
    assert ablations.command() == 0
    whole = rows_of(ablations)
    ablations.RESULT.unlink()

    # Others of the same folder stay; this one is begun anew and dies after its first epoch.
    for path in (folder := ablations.RESULT.parent / "work" / "smaller_no_place").iterdir():
        path.unlink()
    save, seen = training.save_checkpoint, trained(monkeypatch)

    def save_then_die(*args):
        save(*args)
        raise KilledError

    monkeypatch.setattr(training, "save_checkpoint", save_then_die)
    with pytest.raises(KilledError):
        ablations.command()
    assert [row["name"] for row in rows_of(ablations)] == ["base", "fewer maps"]  # Not half of a row.
    assert (folder / "model.safetensors").is_file()
    monkeypatch.setattr(training, "save_checkpoint", save)
    assert ablations.command() == 0
    assert seen == [16, 16]
    again = rows_of(ablations)
    for row in (*whole, *again):
        row.pop("minutes")
    assert again == whole


def test_a_row_of_another_plan_is_not_mixed_in(ablations, tmp_path, capsys):
    assert ablations.command("--rows", "base") == 0
    (tmp_path / "ablations.toml").write_text(PLAN.replace("epochs = 2", "epochs = 1"))
    assert ablations.command("--rows", "fewer maps") == 0
    assert [row["name"] for row in rows_of(ablations)] == ["fewer maps"]
    assert ablations.command() == 2
    assert "with recipe.epochs 2 and not 1; choose another folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("use", "message"),
    [
        ({"options": ["--rows", "larger"]}, "unknown row 'larger'; choose from: base, smaller"),
        ({"test": "data"}, "is of the seed that is trained on; judge on a dataset of another seed"),
        ({"options": ["--data", "four"]}, "--data four names no folder; give NAME=FOLDER"),
        ({"data": "none"}, "none holds no finished dataset"),
    ],
)
def test_wrong_use_is_one_line(ablations, capsys, use, message):
    assert ablations.command(*use.pop("options", []), **use) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.splitlines()) <= 2


def test_a_row_may_be_of_another_dataset(ablations, tmp_path, datasets, capsys):
    (tmp_path / "ablations.toml").write_text(PLAN + OTHER_DATA)
    rows = ("--rows", "base", "of another dataset")
    assert ablations.command(*rows) == 2
    assert "no dataset other; give its folder: --data other=FOLDER" in capsys.readouterr().err

    assert ablations.command("--data", f"other={datasets / 'other'}", *rows) == 0
    assert [row["changes"] for row in rows_of(ablations)] == [{}, {"data": "other"}]
    (info, other) = (
        load_network(tmp_path / "work" / name)[1]["dataset_sha256"] for name in ("base", "of_another_dataset")
    )
    assert info == open_dataset(datasets / "data").sha256 != other == open_dataset(datasets / "other").sha256
    # Without that dataset its row cannot be vouched for.
    assert ablations.command("--rows", "base") == 0
    assert [row["name"] for row in rows_of(ablations)] == ["base"]


def test_too_few_maps_are_said(ablations, tmp_path, capsys):
    (tmp_path / "ablations.toml").write_text(PLAN.replace("maps = 16", "maps = 17"))
    assert ablations.command() == 2
    assert "row base needs 17 training maps, there are 16; make a larger dataset" in capsys.readouterr().err


def test_the_plan_of_the_page_can_be_run(script, tmp_path):
    """Every row is a recipe, each another one, in a folder of its own, and every other differs from the first."""
    module = script("ablations")
    plan = module.tomllib.loads((module.DOCS / "ablations.toml").read_text(encoding="utf-8"))
    rows = [module.Row.of(plan, name, tmp_path) for name in plan["rows"]]
    assert len({row.folder for row in rows}) == len(rows) > 15
    assert len({(str(row.recipe.to_dict()), row.maps, row.data, row.seed) for row in rows}) == len(rows)
    assert rows[0].name == "base" and rows[0].data == ""
    # What ships is a row too, whatever the base was.
    base = plan["base"]
    shipped = Recipe.from_dict({**Recipe.load("footsel").to_dict(), "epochs": base["epochs"]})
    assert shipped.to_dict() in [row.recipe.to_dict() for row in rows]
    # Equal budgets, but for the rows that say what a smaller and a larger one buy.
    budgets = {row.name: row.maps * row.recipe.epochs for row in rows}
    assert budgets.pop("half the maps, as many epochs") == base["maps"] * base["epochs"] / 2
    assert budgets.pop("twice the maps, as many epochs") == 2 * base["maps"] * base["epochs"]
    assert set(budgets.values()) == {base["maps"] * base["epochs"]}
    with pytest.raises(UnknownNameError, match="feature"):
        module.Row.of({**plan, "rows": {"a": {"features": ["luck"]}}}, "a", tmp_path)
