"""Names of a run's files."""

#: Numbers of the leg that the network was built for.
SKELETON_FILE = "skeleton.json"
#: What a training is resumed from, and what is used of it.
CHECKPOINT_FILE = "checkpoint.safetensors"
MODEL_FILE = "model.safetensors"


def weights_file(pair: str) -> str:
    """Name of a pair's weights in a released model folder: what another training can begin with."""
    return f"{pair}.safetensors"
