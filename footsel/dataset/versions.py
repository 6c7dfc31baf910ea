"""Which software makes a label: the same versions and the same seed give the same bytes."""

import os
import platform
import zlib
from functools import cache
from importlib import metadata
from importlib.util import find_spec

import footsel
from footsel.errors import MissingExtraError
from footsel.fingerprint import LABEL_SOURCES, sources_fingerprint

#: Module and distribution of the libraries whose arithmetic is in a label.
_LIBRARIES = {"numpy": "numpy", "scipy": "scipy", "numba": "numba", "coal": "coal", "pinocchio": "pin"}


@cache
def versions() -> dict[str, str]:
    """Versions of footsel, of the libraries below it and of the kind of machine.

    Raises MissingExtraError if a library is not installed; none is loaded.
    """
    source = sources_fingerprint(*LABEL_SOURCES, "dataset")
    found = {"footsel": footsel.__version__, "source": source, "python": platform.python_version()}
    for module, distribution in _LIBRARIES.items():
        if find_spec(module) is None:
            raise MissingExtraError("making a dataset", "oracle", module)
        found[module] = metadata.version(distribution)
    return found | {"zlib": zlib.ZLIB_RUNTIME_VERSION, "machine": f"{platform.machine()} {os.name}"}
