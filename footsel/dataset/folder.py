"""The folder that a dataset grows in: of one configuration and version of the software, one process at a time."""

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from footsel.dataset.config import DatasetConfig
from footsel.dataset.store import MANIFEST, write_json
from footsel.errors import InputError

CONFIG = "config.json"
#: What replace_file leaves behind when it is killed.
_LEFTOVERS = ("*/.shard_*.tmp.npz", ".config.*.tmp.json", ".manifest.*.tmp.json")


@contextmanager
def claimed_folder(path: Path, config: DatasetConfig, versions: dict[str, str]) -> Iterator[None]:
    """Hold a new folder, or one that this configuration and these versions have begun.

    Raises InputError if it holds something else or another process works in it.
    """
    path.mkdir(parents=True, exist_ok=True)
    handle = os.open(path, os.O_RDONLY)
    try:
        _lock(handle, path)
        for pattern in _LEFTOVERS:
            for leftover in path.glob(pattern):
                leftover.unlink()
        _check(path, {"config": asdict(config), "versions": versions})
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


def _check(path: Path, wanted: dict[str, Any]) -> None:
    """Write into an empty folder what it will hold, or compare."""
    wanted = json.loads(json.dumps(wanted))
    file = path / CONFIG
    if not file.exists():
        if any(path.iterdir()):
            raise InputError(f"{path} is not empty and holds no dataset", "choose another folder")
        write_json(file, wanted)
        return
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        differences = [
            f"{name} {found[part].get(name)} and not {value}"
            for part in ("config", "versions")
            for name, value in wanted[part].items()
            if found[part].get(name) != value
        ]
    except (ValueError, KeyError, AttributeError, TypeError):
        raise InputError(f"{file} is damaged", "delete the folder or choose another one") from None
    if differences:
        state = "finished" if (path / MANIFEST).exists() else "begun"
        raise InputError(
            f"{path} holds a dataset of another configuration, {state} with {', '.join(differences)}",
            "choose another folder or delete it",
        )
