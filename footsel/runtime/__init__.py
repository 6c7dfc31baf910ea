"""What runs on the robot: exported networks and the selector over them, on numpy and onnxruntime alone."""

from footsel.runtime.contract import ModelContract
from footsel.runtime.evaluation import CellEvaluation
from footsel.runtime.many import ManyFootholds
from footsel.runtime.model_folder import available_models
from footsel.runtime.network import Network
from footsel.runtime.selector import FootholdSelector, Timing

__all__ = [
    "CellEvaluation",
    "FootholdSelector",
    "ManyFootholds",
    "ModelContract",
    "Network",
    "Timing",
    "available_models",
]
