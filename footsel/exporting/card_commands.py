"""How to make the networks of a model card again: both pairs by one command, or each by its own where they differ."""

import json
from collections.abc import Mapping
from typing import Any

from footsel.learning.recipe import RECIPES, Recipe
from footsel.legs import PAIRS

#: Values of a recipe that `footsel train` takes as options, too.
_OPTIONS = ("epochs", "learning_rate")


def commands(infos: Mapping[str, Mapping[str, Any]], int8: bool) -> list[str]:
    """Markdown lines: what the commands need besides, and the commands.

    infos: pair -> header of the trained model (footsel.learning.checkpoint). int8: whether there is such a variant.
    """
    datasets = {pair: _dataset(info) for pair, info in infos.items()}
    recipes = {pair: _recipe(info) for pair, info in infos.items()}
    data = _names("DATA", "", datasets)
    files = _names("RECIPE", ".toml", recipes)
    trainings = {}
    for pair, info in infos.items():
        options, written = recipes[pair]
        recipe = options if written is None else f"--recipe {files[pair]}"
        start = " --from RELEASE" if info.get("started_from") else ""
        trainings[pair] = f"footsel train {data[pair]} RUN {recipe} --seed {info['seed']}{start} --legs"

    notes = [f"- {files[pair]}: {written}." for pair, (_, written) in recipes.items() if written is not None]
    if any(info.get("started_from") for info in infos.values()):
        notes.append("- RELEASE: the weights that a training began with, see above.")
    if trainings["front"] == trainings["hind"]:
        lines = [f"{trainings['front']} {' '.join(PAIRS)}"]
    else:
        lines = [f"{trainings[pair]} {pair}" for pair in PAIRS]
    return [
        *dict.fromkeys(notes),
        *([""] if notes else []),
        "```sh",
        "pip install 'footsel[train]'",
        *dict.fromkeys(f"footsel dataset {data[pair]} {datasets[pair]}" for pair in PAIRS),
        *lines,
        f"footsel export RUN OUT{' --int8' if int8 else ''}",
        "```",
    ]


def _names(name: str, suffix: str, things: Mapping[str, Any]) -> dict[str, str]:
    """What each pair's is called: one name if they are the same."""
    alike = things["front"] == things["hind"]
    return {pair: f"{name}{suffix}" if alike else f"{name}_{pair.upper()}{suffix}" for pair in things}


def _dataset(info: Mapping[str, Any]) -> str:
    """What follows the dataset's folder."""
    made = info["dataset"]
    families = "".join(f" --{key} {' '.join(made[key])}" for key in ("families", "exclude") if made.get(key))
    return (
        f"--robot {made['robot']} --legs {' '.join(made['pairs'])} --maps {made['maps']} "
        f"--recipe {made['recipe']} --seed {made['seed']}{families}"
    )


def _recipe(info: Mapping[str, Any]) -> tuple[str, str | None]:
    """Options of `footsel train` for the recipe; and what its file is to hold, if it takes one.

    A recipe of an earlier version may lack values that came later.
    """
    changes = {}
    for name in RECIPES:
        shipped = Recipe.load(name).to_dict()
        changes[name] = {
            key: value for key, value in info["recipe"].items() if key != "name" and shipped.get(key) != value
        }
    nearest = min(changes, key=lambda name: len(changes[name]))
    changed = changes[nearest]
    if set(changed) <= set(_OPTIONS):
        options = "".join(f" --{key.replace('_', '-')} {changed[key]}" for key in _OPTIONS if key in changed)
        return f"--recipe {nearest}{options}", None
    values = [f"`{key} = {json.dumps(value)}`" for key, value in changed.items() if value is not None]
    values += [f"no `{key}`" for key, value in changed.items() if value is None]
    return "", f"the recipe `{nearest}` with {', '.join(values)}"
