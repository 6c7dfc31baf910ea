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
from footsel.legs import TRAINED_LEG, check_pair

#: Raised when the meaning of a field changes; a runtime refuses every other number.
SCHEMA = 2
METADATA_KEY = "footsel"

#: Names in the graph: one input of encoded maps (n, planes, 40, 40), all float32.
INPUT = "maps"
#: (n, 14, 40, 40) scores before the softmax.
LOGITS_OUTPUT = "logits"
#: (n, 40, 40) probability of the class "infeasible".
INFEASIBLE_OUTPUT = "infeasible"
#: (n, 40, 40) mean cost over all classes, in [0, 255] (footholds.cost.expected_cost).
COST_OUTPUT = "cost"

#: The only frame there is so far.
FRAME = "heights relative to the hip point L_i of the leg; gravity-aligned, i along the base's heading, j to its left"


@dataclass(frozen=True, eq=False)
class ModelContract:
    """What one ONNX file promises.

    robot: name of the robot description. pair: "front" or "hind". leg: the one of the pair that was trained.
    frame: in words, that of the local maps; FRAME.
    layout: hip points, nominal feet, cell size, height range, foot radius.
    encoding: the input planes.
    classes: channels of the output, the last is "infeasible".
    feasible_below: a cell is feasible if its probability of the class "infeasible" is below this.
    distance_weight: k of the final cost, in [cost / m].
    recipe, dataset_sha256, version: where the weights come from.
    opset: of the graph. commit: of the footsel that exported it, its version where that was not known.

    Raises InputError for a value out of its range.
    """

    robot: str
    pair: str
    leg: str
    frame: str
    layout: LegLayout
    encoding: InputEncoding
    classes: int
    feasible_below: float
    distance_weight: float
    recipe: str
    dataset_sha256: str
    version: str
    opset: int
    commit: str

    def __post_init__(self) -> None:
        trained = TRAINED_LEG[check_pair(self.pair)]
        if self.leg != trained:
            raise InputError(f"the trained leg is {self.leg!r}", f"expected {trained} of the {self.pair} legs")
        if self.frame != FRAME:
            raise InputError(f"the frame is {self.frame!r}", f"expected {FRAME!r}")
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
            "leg": self.leg,
            "frame": self.frame,
            "layout": self.layout.to_dict(),
            "encoding": self.encoding.to_dict(),
            "classes": self.classes,
            "feasible_below": self.feasible_below,
            "distance_weight": self.distance_weight,
            "recipe": self.recipe,
            "dataset_sha256": self.dataset_sha256,
            "version": self.version,
            "opset": self.opset,
            "commit": self.commit,
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
                leg=str(values["leg"]),
                frame=str(values["frame"]),
                layout=LegLayout.from_dict(values["layout"]),
                encoding=InputEncoding.from_dict(values["encoding"]),
                classes=int(values["classes"]),
                feasible_below=float(values["feasible_below"]),
                distance_weight=float(values["distance_weight"]),
                recipe=str(values["recipe"]),
                dataset_sha256=str(values["dataset_sha256"]),
                version=str(values["version"]),
                opset=int(values["opset"]),
                commit=str(values["commit"]),
            )
        except (KeyError, TypeError, ValueError, InputError) as error:
            raise _damaged(source, error) from None


def _damaged(source: str, error: Exception) -> ModelError:
    why = str(error) if isinstance(error, InputError) else repr(error)
    return ModelError(f"{source} has a damaged footsel contract ({why})", "export the model again")
