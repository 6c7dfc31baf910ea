"""Which footsel made a file."""

import subprocess
from pathlib import Path

import footsel

#: A checkout holds the package at its top; an installed one may lie in a folder of somebody else's repository.
_CHECKOUT = Path(footsel.__file__).resolve().parents[1]


def source_commit(checkout: Path = _CHECKOUT) -> str:
    """The commit of the checkout that runs, with `-dirty` if it was edited since; the version where there is none."""
    if not (checkout / ".git").exists():
        return footsel.__version__
    command = ["git", "-C", str(checkout), "describe", "--always", "--exclude=*", "--abbrev=40", "--dirty"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=30)
    except (OSError, subprocess.SubprocessError):
        return footsel.__version__
    return done.stdout.strip()
