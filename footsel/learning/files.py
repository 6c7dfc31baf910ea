"""Names of a run's files."""

#: What a training is resumed from, and what is used of it.
CHECKPOINT_FILE = "checkpoint.safetensors"
MODEL_FILE = "model.safetensors"
