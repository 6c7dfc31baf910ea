"""Compiled functions, kept on disk until any compiled code of the package changes.

numba compares its files on disk with the source file of the function that was called. But what that calls in other
files is compiled into it, and would stay there as it was through edits and upgrades. So the folder of these files is
named after all sources that have compiled functions.
"""

import hashlib
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from footsel.files import cache_folder

Function = TypeVar("Function", bound=Callable[..., Any])

_settings: Any = numba.config


def compiled(function: Function) -> Function:
    """Compile a function when it is first called, or take it from disk.

    It may use functions and constants of other files only if these import from here too.
    """
    folder = _folder()
    if folder is None:
        return cast(Function, numba.njit(function))
    before, _settings.CACHE_DIR = _settings.CACHE_DIR, str(folder)
    try:
        return cast(Function, numba.njit(cache=True)(function))
    finally:
        _settings.CACHE_DIR = before


def inlined(function: Function) -> Function:
    """Write a function's body into the compiled functions that call it."""
    return cast(Function, numba.njit(inline="always")(function))


@cache
def _folder() -> Path | None:
    """Below NUMBA_CACHE_DIR, if that is set, or our own cache folder; None if nothing can be written there."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        source = path.read_bytes()
        if b"footsel.compiled" in source:
            digest.update(source)
    folder = Path(_settings.CACHE_DIR or cache_folder()) / f"compiled-{digest.hexdigest()[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None
