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

import footsel
from footsel.files import replace_file

#: What the comparison runs: rooms and files of the package.
CODE = ("oracle", "robot", "footholds", "terrain", "legs.py")
LIBRARIES = ("coal", "pin", "numpy", "numba")


def code_fingerprint() -> str:
    """Changes with the code of the rooms that are compared and the versions of the libraries under them."""
    root = Path(footsel.__file__).parent
    digest = hashlib.sha256()
    for name in CODE:
        part = root / name
        files = (
            [part] if part.is_file() else [file for file in part.rglob("*") if file.suffix in {".py", ".toml", ".json"}]
        )
        for file in sorted(files):
            digest.update(str(file.relative_to(root)).encode())
            digest.update(file.read_bytes())
    digest.update(repr([version(library) for library in LIBRARIES]).encode())
    return digest.hexdigest()[:16]


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
