"""A short hash of our own code and data: what other code has made is not taken for ours."""

import hashlib
from pathlib import Path

#: What decides a label: rooms and files of the package.
LABEL_SOURCES = ("compiled.py", "legs.py", "terrain", "footholds", "robot", "oracle")

_PACKAGE = Path(__file__).parent
_SUFFIXES = (".py", ".toml", ".json", ".npz")


def sources_fingerprint(*parts: str, root: Path = _PACKAGE) -> str:
    """Of files, and of all code and data in folders, below `root`: one for a release, another after every edit."""
    digest = hashlib.sha256()
    for part in parts:
        path = root / part
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.suffix in _SUFFIXES:
                digest.update(f"{file.relative_to(root).as_posix()}\n".encode() + file.read_bytes())
    return digest.hexdigest()[:16]
