"""Finished parts of a long comparison, kept in a folder, so that a run that was killed goes on where it stopped.

A part is used again only if nothing it depends on has changed: the settings, the code of the rooms it runs, the
libraries under it and the map it looks at.
"""

import hashlib
import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from footsel.files import replace_file
from footsel.fingerprint import LABEL_SOURCES, sources_fingerprint

LIBRARIES = ("coal", "pin", "numpy", "numba")


def code_fingerprint() -> str:
    """Changes with the code of the rooms that are compared and the versions of the libraries under them."""
    versions = " ".join(version(library) for library in LIBRARIES)
    return hashlib.sha256(f"{sources_fingerprint(*LABEL_SOURCES)} {versions}".encode()).hexdigest()[:16]


class Parts:
    """A folder of parts, one JSON file each."""

    def __init__(self, folder: Path, settings: Mapping[str, Any]) -> None:
        self._folder = folder
        self._settings = {**settings, "code": code_fingerprint()}

    def read(self, source: str, leg: str) -> dict[str, Any] | None:
        """A part of these very settings, code and map; None if there is none."""
        try:
            stored = json.loads(self._path(source, leg).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        return stored["part"] if stored.get("key") == self._key(source) else None

    def write(self, source: str, leg: str, part: Mapping[str, Any]) -> None:
        """Keep a part."""
        self._folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"key": self._key(source), "part": part})
        replace_file(self._path(source, leg), lambda path: path.write_text(text, encoding="utf-8"))

    def _path(self, source: str, leg: str) -> Path:
        return self._folder / f"{Path(source).stem}-{leg}.json"

    def _key(self, source: str) -> dict[str, Any]:
        path = Path(source)
        content = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else ""
        return {**self._settings, "source": path.name, "content": content}
