"""How results are written, all at once or not at all, and where what can be made again is kept."""

import glob
import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from footsel.errors import InputError


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` make a file beside `path`, then put it in its place."""
    # The suffix stays, for those writers that choose a format by it.
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.tmp{path.suffix}")
    try:
        write(temporary)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def leftovers(path: Path) -> Iterator[Path]:
    """What writers of `path` that were killed have left beside it."""
    return path.parent.glob(f".{glob.escape(path.stem)}.*.tmp{path.suffix}")


def write_json(path: Path, values: Any) -> None:
    """Write JSON values; raises InputError as `writing` does."""
    text = json.dumps(values, indent=1) + "\n"
    with writing(path):
        replace_file(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Around the writing of long work's results: a full disk or a forbidden folder becomes an InputError."""
    try:
        yield
    except OSError as error:
        raise InputError(
            f"cannot write {path} ({error.strerror or error})",
            "mend that and run the same command again: it goes on from what is there",
        ) from None


def cache_folder() -> Path:
    """`FOOTSEL_CACHE`, or `footsel` below the user's cache folder."""
    chosen = os.environ.get("FOOTSEL_CACHE")
    if chosen:
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "footsel"
