"""Which software makes a label: the same versions and the same seed give the same bytes."""

import hashlib
import os
import platform
import zlib
from functools import cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

import footsel
from footsel.errors import MissingExtraError

#: Module and distribution of the libraries whose arithmetic is in a label.
_LIBRARIES = {"numpy": "numpy", "scipy": "scipy", "numba": "numba", "coal": "coal", "pinocchio": "pin"}
#: The rooms whose code and data decide a label.
_ROOMS = ("terrain", "footholds", "robot", "oracle", "dataset")
_SUFFIXES = (".py", ".toml", ".json", ".npz")


@cache
def versions() -> dict[str, str]:
    """Versions of footsel, of the libraries below it and of the kind of machine.

    Raises MissingExtraError if a library is not installed; none is loaded.
    """
    found = {"footsel": footsel.__version__, "source": _source_fingerprint(), "python": platform.python_version()}
    for module, distribution in _LIBRARIES.items():
        if find_spec(module) is None:
            raise MissingExtraError("making a dataset", "oracle", module)
        found[module] = metadata.version(distribution)
    return found | {"zlib": zlib.ZLIB_RUNTIME_VERSION, "machine": f"{platform.machine()} {os.name}"}


def _source_fingerprint() -> str:
    """Of the code and data that decide a label: one for a release, another after every edit of a working copy."""
    root = Path(footsel.__file__).parent
    digest = hashlib.sha256()
    for room in _ROOMS:
        for file in sorted((root / room).rglob("*")):
            if file.suffix in _SUFFIXES:
                digest.update(f"{file.relative_to(root).as_posix()}\n".encode() + file.read_bytes())
    return digest.hexdigest()[:16]
