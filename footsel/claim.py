"""A folder that grows over several runs is of one configuration, which its `config.json` says, and of one process."""

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from textwrap import shorten
from typing import Any

from footsel.errors import InputError
from footsel.files import leftovers, write_json

CONFIG = "config.json"


@contextmanager
def sole_process(folder: Path, content: str) -> Iterator[None]:
    """Make the folder if it is not there and hold it; raises InputError if another process makes the same in it."""
    folder.mkdir(parents=True, exist_ok=True)
    handle = os.open(folder, os.O_RDONLY)
    try:
        _lock(handle, folder, content)
        yield
    finally:
        os.close(handle)


def claim_folder(folder: Path, content: str, config: Mapping[str, Any], notes: Mapping[str, Any] | None = None) -> None:
    """Write the configuration into a new or empty folder, or check that it is the folder's.

    content: what the folder holds, for the error: "dataset". config: JSON values that every run must bring again.
    notes: of the first run, written beside them and never compared.
    Raises InputError if the folder holds something else, or is of another configuration: the error says which values
    differ.
    """
    path = folder / CONFIG
    wanted = json.loads(json.dumps(config))
    if not path.exists():
        folder.mkdir(parents=True, exist_ok=True)
        if set(folder.iterdir()) - set(leftovers(path)):
            raise InputError(f"{folder} is not empty and holds no {content}", "choose another folder")
        write_json(path, {**wanted, **(notes or {})})
        return
    try:
        found = dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError):
        raise InputError(f"{path} is damaged", "delete the folder or choose another one") from None
    differences = [line for key, value in wanted.items() for line in _differences(key, found.get(key), value)]
    if differences:
        raise InputError(
            f"{folder} holds a {content} of another configuration, with {', '.join(differences)}",
            "choose another folder or delete it",
        )


def _lock(handle: int, folder: Path, content: str) -> None:
    """Until the handle is closed or the process is gone, however it ends."""
    import fcntl  # There is none on Windows.

    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InputError(
            f"another process makes {content} in {folder}", "wait for it, or choose another folder"
        ) from None
    except OSError:
        pass  # A file system without locks.


def _differences(name: str, found: Any, wanted: Any) -> Iterator[str]:
    """In words, value by value; None where there is none."""
    if isinstance(found, dict) and isinstance(wanted, dict):
        for key in {**found, **wanted}:
            yield from _differences(f"{name}.{key}", found.get(key), wanted.get(key))
    elif found != wanted:
        yield f"{name} {_short(found)} and not {_short(wanted)}"


def _short(value: Any) -> str:
    return shorten(str(value), 60, placeholder=" ...")
