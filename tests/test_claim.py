"""A folder is of one configuration, and says what differs from another."""

import json
import re

import pytest

from footsel.claim import CONFIG, claim_folder
from footsel.errors import InputError

#: A tuple is read back as a list.
VALUES = {"seed": 0, "recipe": {"epochs": 3, "planes": ("height", "roll")}, "families": None}


def refusal(folder, values):
    with pytest.raises(InputError) as caught:
        claim_folder(folder, "fruit bowl", values)
    return str(caught.value)


def test_the_same_configuration_comes_again(tmp_path):
    folder = tmp_path / "new" / "folder"
    claim_folder(folder, "fruit bowl", VALUES, notes={"threads": 1})
    before = (folder / CONFIG).read_bytes()
    assert json.loads(before)["threads"] == 1
    (folder / "apple").touch()
    claim_folder(folder, "fruit bowl", VALUES, notes={"threads": 2})
    assert (folder / CONFIG).read_bytes() == before


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"seed": 1}, "seed 0 and not 1"),
        ({"families": ["flat"]}, "families None and not ['flat']"),
        ({"recipe": {"epochs": 4, "planes": ("height", "roll")}}, "recipe.epochs 3 and not 4"),
        ({"recipe": {"planes": ("height", "roll")}}, "recipe.epochs 3 and not None"),
        ({"recipe": None}, "recipe {'epochs': 3, 'planes': ['height', 'roll']} and not None"),
        ({"seed": 1, "name": "x"}, "seed 0 and not 1, name None and not x"),
    ],
)
def test_another_configuration_is_refused_and_told(tmp_path, change, line):
    claim_folder(tmp_path, "fruit bowl", VALUES)
    before = (tmp_path / CONFIG).read_bytes()
    assert refusal(tmp_path, {**VALUES, **change}) == (
        f"{tmp_path} holds a fruit bowl of another configuration, with {line}; choose another folder or delete it"
    )
    assert (tmp_path / CONFIG).read_bytes() == before


def test_long_values_are_cut(tmp_path):
    claim_folder(tmp_path, "fruit bowl", VALUES)
    assert len(refusal(tmp_path, {**VALUES, "families": ["a word"] * 999})) < 300


def test_a_folder_with_other_things_is_left_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    assert re.search("is not empty and holds no fruit bowl", refusal(tmp_path, VALUES))
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_what_a_killed_run_left_is_nothing(tmp_path):
    (tmp_path / ".config.4711.tmp.json").write_text("{")
    claim_folder(tmp_path, "fruit bowl", VALUES)
    claim_folder(tmp_path, "fruit bowl", VALUES)


@pytest.mark.parametrize("text", ["", "{", "3", "[1]", "null"])
def test_a_damaged_file_is_named(tmp_path, text):
    (tmp_path / CONFIG).write_text(text)
    assert f"{tmp_path / CONFIG} is damaged" in refusal(tmp_path, VALUES)
