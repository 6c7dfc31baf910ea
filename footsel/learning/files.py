"""Names of a run's files, and how they are written: all at once or not at all."""

import os
from collections.abc import Callable
from pathlib import Path

#: What a training is resumed from, and what is used of it.
CHECKPOINT_FILE = "checkpoint.safetensors"
MODEL_FILE = "model.safetensors"


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` make a file beside `path`, then put it in its place."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        write(temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
