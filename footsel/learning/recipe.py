"""Training recipes: every choice that makes one training differ from another, read from TOML."""

import math
import sys
from collections.abc import Mapping
from dataclasses import MISSING, asdict, dataclass, fields
from importlib import resources
from itertools import pairwise
from pathlib import Path
from typing import Any

from footsel.errors import InputError, UnknownNameError
from footsel.footholds.encoding import InputEncoding

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

#: footsel.learning.erfnet, footsel.learning.footnet. What the latter sees beside the input planes.
ARCHITECTURES = ("erfnet", "footnet")
FEATURES = ("place", "posture", "clearance", "footing", "hip")

#: Recipes that ship with footsel, as `recipes/NAME.toml`; their comments say where each value comes from.
RECIPES = ("paper", "footsel")

_CHOICES = {
    "architecture": ARCHITECTURES,
    "schedule": ("exponential", "one_cycle"),
    "class_weights": ("paper", "none"),
    "precision": ("auto", "float32", "bfloat16"),
}


@dataclass(frozen=True)
class Recipe:
    """How a network is trained.

    name: "paper", "footsel" or the name of the user's file.
    planes, quantised: the input encoding. epochs: passes over the training maps. batch_size: maps per update.
    schedule: "exponential" (decays by `decay` per epoch over `decay_epochs` epochs, or as far in fewer epochs) or
        "one_cycle" (up to `learning_rate` and down again). weight_decay: Adam's L2 penalty.
    class_weights: "paper" or "none". calibrated: whether the weights' tilt towards rare classes is taken out of the
        trained network's logits again. ema_decay: of the weights' moving average, per update; 0 keeps none.
    precision: "auto", "float32" or "bfloat16" arithmetic of the forward pass.
    architecture: "erfnet" or "footnet"; for the latter cells, widths, blocks and features
        (footsel.learning.footnet.FootNet).
    balls: along the leg, for the feature "clearance"; 0 for all that there are (footsel.learning.ball_choice).
    fit_balls: whether their places and how far they reach are fitted to collisions first (footsel.learning.ball_fit).
    ordinal, reason_weight, collision_weight, scarcity: of the loss (footsel.learning.loss).
    noise, holes: shares of the training maps that come with a depth camera's noise, with hidden cells. shift: standard
        deviation of a training map's height, in [m] (footsel.learning.augmentation).
    """

    name: str
    planes: tuple[str, ...]
    quantised: bool
    epochs: int
    batch_size: int
    schedule: str
    learning_rate: float
    weight_decay: float
    class_weights: str
    calibrated: bool
    ema_decay: float
    precision: str
    decay: float | None = None
    decay_epochs: int | None = None
    architecture: str = "erfnet"
    cells: tuple[int, ...] = ()
    widths: tuple[int, ...] = ()
    blocks: tuple[int, ...] = ()
    features: tuple[str, ...] = ()
    balls: int = 0
    fit_balls: bool = False
    ordinal: float = 0.0
    reason_weight: float = 0.0
    collision_weight: float = 1.0
    noise: float = 0.0
    holes: float = 0.0
    shift: float = 0.0
    scarcity: float = 1.0

    def __post_init__(self) -> None:
        for key in ("planes", "cells", "widths", "blocks", "features"):
            object.__setattr__(self, key, tuple(getattr(self, key)))
        InputEncoding(self.planes)
        for key, known in _CHOICES.items():
            if getattr(self, key) not in known:
                raise UnknownNameError(f"{key} of recipe {self.name}", getattr(self, key), known)
        self._check("quantised", isinstance(self.quantised, bool), "true or false")
        self._check("calibrated", isinstance(self.calibrated, bool), "true or false")
        self._check("fit_balls", isinstance(self.fit_balls, bool), "true or false")
        self._check("epochs", _is_whole(self.epochs) and self.epochs >= 1, "a whole number of 1 or more")
        self._check("batch_size", _is_whole(self.batch_size) and self.batch_size >= 1, "a whole number of 1 or more")
        self._check("learning_rate", _is_number(self.learning_rate) and self.learning_rate > 0, "a number above 0")
        self._check("weight_decay", _is_number(self.weight_decay) and self.weight_decay >= 0, "a number of 0 or more")
        self._check("ema_decay", _is_number(self.ema_decay) and 0 <= self.ema_decay < 1, "a number in [0, 1)")
        self._check("ordinal", _is_number(self.ordinal) and self.ordinal >= 0, "a number of 0 or more")
        self._check(
            "reason_weight", _is_number(self.reason_weight) and self.reason_weight >= 0, "a number of 0 or more"
        )
        self._check("collision_weight", _is_number(self.collision_weight) and self.collision_weight > 0, "above 0")
        self._check("scarcity", _is_number(self.scarcity) and self.scarcity >= 1, "a number of 1 or more")
        for key in ("noise", "holes"):
            share = getattr(self, key)
            self._check(key, _is_number(share) and 0 <= share <= 1, "a share from 0 to 1")
        self._check("shift", _is_number(self.shift) and self.shift >= 0, "a length of 0 or more, in metres")
        self._check_network()
        if self.schedule == "exponential":
            self._check("decay", _is_number(self.decay) and 0 < float(self.decay or 0) <= 1, "a number in (0, 1]")
            self._check("decay_epochs", _is_whole(self.decay_epochs) and int(self.decay_epochs or 0) >= 1, "1 or more")

    def _check_network(self) -> None:
        if self.architecture == "erfnet":
            for key in ("cells", "widths", "blocks", "features"):
                self._check(key, not getattr(self, key), "none: ERFNet has its own")
            self._check("balls", self.balls == 0 and not self.fit_balls, "none: ERFNet has its own")
            self._check("reason_weight", self.reason_weight == 0, "0: ERFNet has one output")
            return
        self._check("balls", _is_whole(self.balls) and self.balls >= 0, "a number, 0 for all")
        whole = all(_is_whole(width) and width > 0 for width in (*self.cells, *self.widths))
        self._check("cells", whole and len(self.cells) >= 1, "numbers of channels, one or more")
        sides = (*self.cells[-1:], *self.widths)
        growing = all(one < other for one, other in pairwise(sides))
        self._check("widths", whole and len(self.widths) <= 2 and growing, "at most two, more than the last of cells")
        counts = all(_is_whole(count) and count >= 0 for count in self.blocks)
        self._check("blocks", len(self.blocks) == len(sides) and counts, "a number for 40x40 and for each of widths")
        for feature in self.features:
            if feature not in FEATURES:
                raise UnknownNameError(f"feature of recipe {self.name}", feature, FEATURES)
        together = "hip" not in self.features or "clearance" in self.features
        self._check("features", together, '"clearance" too, with which "hip" is looked up')

    def _check(self, key: str, good: bool, expected: str) -> None:
        if not good:
            raise InputError(f"{key} of recipe {self.name} is {getattr(self, key)!r}", f"give {expected}")

    @classmethod
    def load(cls, recipe: str | Path) -> "Recipe":
        """A shipped recipe by name, or the user's own TOML file.

        Raises UnknownNameError for a name that is neither, InputError for a file that does not fit.
        """
        if str(recipe) in RECIPES:
            text = (resources.files("footsel.learning") / "recipes" / f"{recipe}.toml").read_text(encoding="utf-8")
            return cls._parse(str(recipe), text)
        path = Path(recipe)
        if path.suffix != ".toml":
            raise UnknownNameError("recipe", str(recipe), (*RECIPES, "a .toml file"))
        try:
            return cls._parse(path.stem, path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            raise InputError(f"cannot read recipe {path} ({error})", "give a TOML file like the shipped ones") from None

    @classmethod
    def _parse(cls, name: str, text: str) -> "Recipe":
        try:
            values = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise InputError(f"recipe {name} is no TOML ({error})", "correct the file") from None
        return cls.from_dict({"name": name, **values})

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "Recipe":
        """From the values of `to_dict` or of a TOML file; raises InputError for keys that are missing or unknown."""
        name = values.get("name", "without name")
        known = {field.name for field in fields(cls)}
        if unknown := sorted(set(values) - known):
            raise UnknownNameError(f"key of recipe {name}", unknown[0], sorted(known))
        required = {field.name for field in fields(cls) if field.default is MISSING}
        if missing := sorted(required - set(values)):
            raise InputError(f"recipe {name} lacks {', '.join(missing)}", "copy a shipped recipe and change its values")
        return cls(**values)

    def to_dict(self) -> dict[str, Any]:
        """Plain JSON values; `from_dict` is its inverse."""
        return {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(self).items()}

    def encoding(self, height_range: float) -> InputEncoding:
        """The network's input for a robot whose depth image spans `height_range`, in [m]."""
        return InputEncoding(self.planes, self.quantised, height_range)


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
