"""A training that begins with the weights of another: of a run, of a released model, or of a file of either.

So a network can learn in several sittings, over days and machines, and its card says what it came from.
"""

from pathlib import Path
from typing import Any

from footsel.errors import ModelError
from footsel.learning.checkpoint import read_model
from footsel.learning.files import MODEL_FILE, weights_file
from footsel.learning.footnet import input_names
from footsel.learning.learner import Learner
from footsel.learning.pruning import narrowed, with_inputs
from footsel.learning.recipe import Recipe
from footsel.learning.skeleton import LegSkeleton
from footsel.runtime.model_folder import checksum, find_model_folder

#: What must be the same in both recipes for weights to fit. FootNet may have other planes, which only its fixed layers
#: see, fewer channels in `cells`, fewer balls and more features.
_SHAPE = ("architecture", "widths", "blocks")


def find_weights(start: str | Path, pair: str) -> Path:
    """The file of a pair's weights in a run folder, one pair's folder, a model folder or its name; or the file itself.

    Raises ModelError if there is none.
    """
    path = Path(start)
    if path.is_file():
        return path
    folders = [path / pair / MODEL_FILE, path / MODEL_FILE] if path.is_dir() else []
    if found := next((file for file in folders if file.is_file()), None):
        return found
    released = find_model_folder(start) / weights_file(pair)
    if not released.is_file():
        raise ModelError(f"{released.parent} holds no weights to go on from", "give a folder of `footsel train`")
    return released


def lineage(start: str | Path, pair: str) -> dict[str, Any]:
    """What a model that begins with another says of it: the file's hash, its data, and what it came from in turn."""
    path = find_weights(start, pair)
    info = read_model(path)[1]
    if info.get("pair") != pair:
        raise ModelError(f"{path} was trained for the {info.get('pair')} legs, not {pair}", "give a folder of both")
    return {
        "sha256": checksum(path.read_bytes()),
        "dataset_sha256": info["dataset_sha256"],
        "recipe": info["recipe"]["name"],
        "epochs": info["epochs_done"],
        "version": info["version"],
        "started_from": info.get("started_from"),
    }


def skeleton_of(start: str | Path | None, pair: str) -> LegSkeleton | None:
    """The skeleton that the weights to begin with were trained for; None without them, or if they had none."""
    values = None if start is None else read_model(find_weights(start, pair))[1].get("skeleton")
    return None if values is None else LegSkeleton.from_dict(values)


def start_from(learner: Learner, start: str | Path, pair: str) -> None:
    """Give a fresh learner the weights of another training.

    The class weights' tilt comes back, as the recipe at hand has it. Only what no class depends on may be missing. A
    recipe with fewer channels in `cells`, and no context, begins with the weights that matter most
    (footsel.learning.pruning); one with more features begins blind to them.
    Raises ModelError if the weights are of another architecture or input.
    """
    path = find_weights(start, pair)
    weights, info = read_model(path)
    theirs, ours = Recipe.from_dict(info["recipe"]), learner.recipe
    shape = list(_SHAPE)
    if ours.architecture == "erfnet":
        shape.append("planes")
    if not _is_narrower(ours, theirs):
        shape.append("cells")
    if not set(theirs.features) <= set(ours.features):
        shape.append("features")
    if not (ours.balls == theirs.balls or 0 < ours.balls < theirs.balls):
        shape.append("balls")
    for key in shape:
        if getattr(theirs, key) != getattr(ours, key):
            raise ModelError(
                f"{path} has {key} {getattr(theirs, key)}, the recipe {getattr(ours, key)}",
                f"continue with a recipe of the same {', '.join(shape)}",
            )
    if theirs.cells != ours.cells:
        weights = narrowed(weights, ours.cells)
    if ours.architecture == "footnet":
        assert learner.skeleton is not None
        names = input_names(theirs.features, LegSkeleton.from_dict(info["skeleton"]))
        weights = with_inputs(weights, names, input_names(ours.features, learner.skeleton))
    try:
        learner.adopt(weights)
    except RuntimeError:
        raise ModelError(f"{path} holds no network of this footsel", "train from the beginning") from None


def _is_narrower(ours: Recipe, theirs: Recipe) -> bool:
    """Whether one network is the other with channels left out."""
    fewer = all(our <= their for our, their in zip(ours.cells, theirs.cells, strict=False))
    return len(ours.cells) == len(theirs.cells) and fewer and not (ours.widths or any(ours.blocks))
