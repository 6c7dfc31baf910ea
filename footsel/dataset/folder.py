"""The folder that a dataset grows in: of one configuration and version of the software, one process at a time."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from footsel.claim import CONFIG, claim_folder, sole_process
from footsel.dataset.config import DatasetConfig
from footsel.dataset.store import MANIFEST
from footsel.files import leftovers

#: What a killed writer leaves behind.
_LEFTOVER_SHARDS = "*/.shard_*.tmp.npz"


@contextmanager
def claimed_folder(path: Path, config: DatasetConfig, versions: dict[str, str]) -> Iterator[None]:
    """Hold a new folder, or one that this configuration and these versions have begun.

    Raises InputError if it holds something else or another process works in it.
    """
    with sole_process(path, "a dataset"):
        for leftover in (*leftovers(path / CONFIG), *leftovers(path / MANIFEST), *path.glob(_LEFTOVER_SHARDS)):
            leftover.unlink()
        content = "finished dataset" if (path / MANIFEST).exists() else "dataset"
        claim_folder(path, content, {"config": asdict(config), "versions": versions})
        yield
