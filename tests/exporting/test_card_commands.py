"""The commands of the model card: the parsers of the commands take them, and they say what was run."""

import re
import shlex

import pytest

from footsel.cli.main import make_parser
from footsel.exporting.card_commands import commands
from footsel.learning.recipe import RECIPES, Recipe

DATASET = {"robot": "anymal_b", "pairs": ["front", "hind"], "maps": 900, "seed": 3, "recipe": "footsel"}


def info(recipe="footsel", dataset=DATASET, started_from=None, **changes):
    used = {**Recipe.load(recipe).to_dict(), **changes}
    return {"recipe": used, "dataset": dataset, "seed": 0, "started_from": started_from}


def lines(*infos, int8=False):
    found = commands(dict(zip(("front", "hind"), infos, strict=True)), int8)
    for line in found:
        if line.startswith("footsel "):
            make_parser().parse_args(shlex.split(line)[1:])
    return found


@pytest.mark.parametrize("recipe", RECIPES)
def test_pairs_alike_take_one_command_each(recipe):
    assert lines(info(recipe), info(recipe), int8=True) == [
        "```sh",
        "pip install 'footsel[train]'",
        "footsel dataset DATA --robot anymal_b --legs front hind --maps 900 --recipe footsel --seed 3",
        f"footsel train DATA RUN --recipe {recipe} --seed 0 --legs front hind",
        "footsel export RUN OUT --int8",
        "```",
    ]


def test_what_the_command_takes_needs_no_file():
    found = lines(*[info(epochs=2, learning_rate=2e-3, started_from={"sha256": "0"})] * 2)
    assert (
        "footsel train DATA RUN --recipe footsel --epochs 2 --learning-rate 0.002 --seed 0 --from RELEASE"
        in "\n".join(found)
    )
    assert found[0].startswith("- RELEASE: ") and not any(".toml" in line for line in found)


def test_pairs_that_differ_have_commands_of_their_own():
    other = {**DATASET, "seed": 4, "exclude": ["gaps", "rubble"]}
    found = lines(info(weight_decay=1e-3), info(dataset=other, ordinal=0.0, decay_epochs=None, name="mine"))
    text = "\n".join(found)
    assert found[0] == "- RECIPE_FRONT.toml: the recipe `footsel` with `weight_decay = 0.001`."
    assert found[1] == "- RECIPE_HIND.toml: the recipe `footsel` with `ordinal = 0.0`."
    assert re.findall(r"footsel dataset (\S+) .* --seed (.*)", text) == [
        ("DATA_FRONT", "3"),
        ("DATA_HIND", "4 --exclude gaps rubble"),
    ]
    assert re.findall(r"footsel train (\S+) RUN --recipe (\S+) .*--legs (.*)", text) == [
        ("DATA_FRONT", "RECIPE_FRONT.toml", "front"),
        ("DATA_HIND", "RECIPE_HIND.toml", "hind"),
    ]


def test_a_value_that_the_shipped_recipe_has_and_this_one_not():
    changed = {"schedule": "one_cycle", "decay": None, "decay_epochs": None}
    found = lines(info("paper", **changed), info("paper", **changed))
    assert found[0] == '- RECIPE.toml: the recipe `paper` with `schedule = "one_cycle"`, no `decay`, no `decay_epochs`.'
    assert sum(line.startswith("- ") for line in found) == 1
