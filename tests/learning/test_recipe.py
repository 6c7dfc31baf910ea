"""Recipes: what the shipped ones say, what a wrong one is told, and the schedules they ask for."""

import math
import re
from dataclasses import replace

import pytest

from footsel.errors import InputError, UnknownNameError
from footsel.learning.recipe import RECIPES, Recipe
from footsel.learning.schedule import decay_per_epoch, learning_rate


def test_the_paper_recipe_is_the_papers():
    recipe = Recipe.load("paper")
    assert (recipe.planes, recipe.quantised, recipe.epochs) == (("height",), True, 500)
    assert (recipe.schedule, recipe.learning_rate, recipe.decay) == ("exponential", 5e-4, 0.98)
    assert recipe.class_weights == "paper" and recipe.weight_decay > 0 and recipe.ema_decay == 0


@pytest.mark.parametrize("name", RECIPES)
def test_recipes_survive_json(name):
    recipe = Recipe.load(name)
    assert recipe.name == name
    assert Recipe.from_dict(recipe.to_dict()) == recipe
    assert recipe.encoding(0.85).planes == recipe.planes


def test_a_file_of_ones_own(tmp_path):
    text = "\n".join(
        f"{key} = {str(value).lower() if isinstance(value, bool) else repr(value)}"
        for key, value in Recipe.load("footsel").to_dict().items()
        if key != "name" and value is not None
    )
    path = tmp_path / "quick.toml"
    path.write_text(re.sub(r"(?m)^epochs = \d+", "epochs = 3", text))
    assert Recipe.load(path) == replace(Recipe.load("footsel"), name="quick", epochs=3)

    path.write_text(text + "\nepoch = 3")
    with pytest.raises(UnknownNameError, match=r"unknown key of recipe quick 'epoch'; choose from: .*epochs"):
        Recipe.load(path)
    path.write_text(text.replace("batch_size", "# batch_size"))
    with pytest.raises(InputError, match="lacks batch_size"):
        Recipe.load(path)
    path.write_text("epochs = ")
    with pytest.raises(InputError, match="no TOML"):
        Recipe.load(path)
    with pytest.raises(UnknownNameError, match="unknown recipe 'best'; choose from: paper, footsel"):
        Recipe.load("best")
    with pytest.raises(InputError, match="cannot read recipe"):
        Recipe.load(tmp_path / "absent.toml")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("epochs", 0),
        ("epochs", 2.5),
        ("batch_size", 0),
        ("learning_rate", 0.0),
        ("learning_rate", math.nan),
        ("weight_decay", -1e-4),
        ("ema_decay", 1.0),
        ("quantised", "yes"),
        ("schedule", "linear"),
        ("class_weights", "enet"),
        ("precision", "float16"),
        ("planes", ("depth",)),
        ("decay", None),
        ("decay_epochs", 0),
    ],
)
def test_a_wrong_value_is_named(key, value):
    with pytest.raises(InputError, match=r"depth|" + str(value).replace(".", r"\.")):
        replace(Recipe.load("paper"), **{key: value})


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("architecture", "unet"),
        ("cells", ()),
        ("cells", (64, 0)),
        ("cells", (64, 1.5)),
        ("widths", (48, 64, 96)),
        ("widths", (16,)),
        ("blocks", (1, 2)),
        ("blocks", (-1,)),
        ("features", ("place", "colour")),
        ("balls", -1),
        ("ordinal", -1),
        ("reason_weight", math.inf),
        ("collision_weight", 0),
        ("scarcity", 0.5),
        ("noise", -0.5),
        ("noise", 1.5),
        ("holes", -0.1),
    ],
)
def test_a_wrong_network_or_loss_is_named(key, value):
    with pytest.raises(InputError, match=f"{key[:6]}.*of recipe footsel"):
        replace(Recipe.load("footsel"), **{key: value})


@pytest.mark.parametrize(
    ("key", "value"),
    [("cells", (48, 32)), ("widths", (48,)), ("features", ("place",)), ("balls", 6), ("reason_weight", 0.5)],
)
def test_erfnet_has_no_choices(key, value):
    with pytest.raises(InputError, match=f"{key} of recipe paper .*ERFNet"):
        replace(Recipe.load("paper"), **{key: value})


def test_a_recipe_of_before_these_choices_is_erfnet_with_none_of_them():
    values = Recipe.load("paper").to_dict()
    new = (
        "architecture",
        "cells",
        "widths",
        "blocks",
        "features",
        "balls",
        "ordinal",
        "reason_weight",
        "collision_weight",
    )
    new += ("noise", "holes", "shift", "scarcity")
    assert Recipe.from_dict({key: value for key, value in values.items() if key not in new}) == Recipe.load("paper")


def test_decay_ends_where_500_epochs_would():
    paper = Recipe.load("paper")
    assert decay_per_epoch(paper) == pytest.approx(0.98)
    assert learning_rate(paper, 3, 7, 100) == pytest.approx(5e-4 * 0.98**3)
    short = replace(paper, epochs=20)
    # One more decay after the last epoch, in both.
    assert 5e-4 * decay_per_epoch(short) ** 20 == pytest.approx(5e-4 * 0.98**500)
    assert learning_rate(short, 0, 0, 100) == 5e-4


def test_one_cycle_rises_to_the_peak_and_ends_low():
    recipe = replace(Recipe.load("footsel"), epochs=10)
    rates = [learning_rate(recipe, epoch, batch, 10) for epoch in range(10) for batch in range(10)]
    top = rates.index(max(rates))
    assert max(rates) == pytest.approx(recipe.learning_rate, rel=1e-2) and top == 30
    assert rates[0] == pytest.approx(recipe.learning_rate / 25) and rates[-1] == pytest.approx(
        recipe.learning_rate / 25 / 1e4
    )
    assert rates[:top] == sorted(rates[:top]) and rates[top:] == sorted(rates[top:], reverse=True)
    assert learning_rate(replace(recipe, epochs=1), 0, 0, 1) > 0
