"""The folder that a dataset grows in: of one configuration and version of the software, one process at a time."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from footsel.claim import CONFIG, claim_folder
from footsel.dataset.config import DatasetConfig
from footsel.dataset.store import MANIFEST
from footsel.errors import InputError
from footsel.files import leftovers

#: What a killed writer leaves behind.
_LEFTOVER_SHARDS = "*/.shard_*.tmp.npz"


@contextmanager
def claimed_folder(path: Path, config: DatasetConfig, versions: dict[str, str]) -> Iterator[None]:
    """Hold a new folder, or one that this configuration and these versions have begun.

    Raises InputError if it holds something else or another process works in it.
    """
    path.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDONLY)
    try:
        _lock(handle, path)
        for leftover in (*leftovers(path / CONFIG), *leftovers(path / MANIFEST), *path.glob(_LEFTOVER_SHARDS)):
            leftover.unlink()
        content = "finished dataset" if (path / MANIFEST).exists() else "dataset"
        claim_folder(path, content, {"config": asdict(config), "versions": versions})
        yield
    finally:
        os.close(handle)


def _lock(handle: int, path: Path) -> None:
    """Until the handle is closed or the process is gone, however it ends."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InputError(
            f"another process makes a dataset in {path}", "wait for it, or choose another folder"
        ) from None
    except OSError:
        pass  # A file system without locks.
