"""The contract that travels in an ONNX file's metadata: everything a runtime needs to use the network."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from footsel.errors import ModelError
from footsel.footholds.encoding import InputEncoding
from footsel.footholds.layout import LegLayout

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
            if values["schema"] != SCHEMA:
                raise ModelError(
                    f"{source} has contract schema {values['schema']}, this footsel reads {SCHEMA}",
                    "export the model again with this version",
                )
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
        except (KeyError, TypeError, ValueError) as error:
            raise ModelError(f"{source} has a damaged footsel contract ({error!r})", "export the model again") from None
