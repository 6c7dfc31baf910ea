"""The contract that travels in an ONNX file's metadata: everything a runtime needs to use the network."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from footsel.errors import InputError, ModelError
from footsel.footholds.cost import CLASSES
from footsel.footholds.encoding import InputEncoding
from footsel.footholds.layout import LegLayout
from footsel.legs import check_pair

#: Raised when the meaning of a field changes; a runtime refuses every other number.
SCHEMA = 1
METADATA_KEY = "footsel"


@dataclass(frozen=True, eq=False)
class ModelContract:
    """What one ONNX file promises.

    robot: name of the robot description. pair: "front" or "hind".
    layout: hip points, nominal feet, cell size, height range, foot radius.
    encoding: the input planes.
    classes: channels of the output, the last is "infeasible".
    feasible_below: a cell is feasible if its probability of the class "infeasible" is below this.
    distance_weight: k of the final cost, in [cost / m].
    recipe, dataset_sha256, version: where the weights come from.

    Raises InputError for a value out of its range.
    """

    robot: str
    pair: str
    layout: LegLayout
    encoding: InputEncoding
    classes: int
    feasible_below: float
    distance_weight: float
    recipe: str
    dataset_sha256: str
    version: str

    def __post_init__(self) -> None:
        check_pair(self.pair)
        if self.classes != CLASSES:
            raise InputError(f"the contract has {self.classes} classes", f"expected {CLASSES}")
        if not 0 < self.feasible_below <= 1:
            raise InputError(f"feasible_below is {self.feasible_below}", "expected a probability above 0")
        if not (math.isfinite(self.distance_weight) and self.distance_weight >= 0):
            raise InputError(f"distance_weight is {self.distance_weight}", "expected a cost per metre of 0 or more")

    def to_json(self) -> str:
        """The metadata entry."""
        values = {
            "schema": SCHEMA,
            "robot": self.robot,
            "pair": self.pair,
            "layout": self.layout.to_dict(),
            "encoding": self.encoding.to_dict(),
            "classes": self.classes,
            "feasible_below": self.feasible_below,
            "distance_weight": self.distance_weight,
            "recipe": self.recipe,
            "dataset_sha256": self.dataset_sha256,
            "version": self.version,
        }
        return json.dumps(values, sort_keys=True)

    @classmethod
    def from_metadata(cls, metadata: Mapping[str, str], source: str) -> "ModelContract":
        """Read the contract of the file `source`; raises ModelError if it is missing, foreign or of another schema."""
        if METADATA_KEY not in metadata:
            raise ModelError(f"{source} carries no footsel contract", "use a model written by `footsel export`")
        try:
            values: dict[str, Any] = json.loads(metadata[METADATA_KEY])
            schema = values["schema"]
        except (KeyError, TypeError, ValueError) as error:
            raise _damaged(source, error) from None
        if schema != SCHEMA:
            raise ModelError(
                f"{source} has contract schema {schema}, this footsel reads {SCHEMA}",
                "export the model again with this version",
            )
        try:
            return cls(
                robot=str(values["robot"]),
                pair=str(values["pair"]),
                layout=LegLayout.from_dict(values["layout"]),
                encoding=InputEncoding.from_dict(values["encoding"]),
                classes=int(values["classes"]),
                feasible_below=float(values["feasible_below"]),
                distance_weight=float(values["distance_weight"]),
                recipe=str(values["recipe"]),
                dataset_sha256=str(values["dataset_sha256"]),
                version=str(values["version"]),
            )
        except (KeyError, TypeError, ValueError, InputError) as error:
            raise _damaged(source, error) from None


def _damaged(source: str, error: Exception) -> ModelError:
    return ModelError(f"{source} has a damaged footsel contract ({error!r})", "export the model again")
