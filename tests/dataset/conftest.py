"""A small dataset, the command line as a process of its own, and what all files of a folder hash to."""

import hashlib
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from footsel.dataset.config import DatasetConfig
from footsel.dataset.generate import generate

#: The same dataset, as configuration and as command.
CONFIG = DatasetConfig(
    robot="anymal_b", pairs=("front", "hind"), maps=12, seed=3, recipe="footsel", maps_per_shard=4, maps_per_course=2
)


def digests_of(folder: Path) -> dict[str, str]:
    """sha256 of every file below a folder, hidden ones too."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def start_footsel(*arguments: object, limit: Callable[[], None] | None = None) -> "subprocess.Popen[str]":
    """`footsel dataset ARGUMENTS` in a session of its own, as a terminal would start it."""

    def prepare() -> None:
        # A shell's background job ignores interrupts, and so would its children, these tests' too.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        if limit is not None:
            limit()

    return subprocess.Popen(
        [sys.executable, "-m", "footsel.cli.main", "dataset", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=prepare,  # noqa: PLW1509 - the tests have no threads
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )


@pytest.fixture(scope="session")
def digests() -> Callable[[Path], dict[str, str]]:
    return digests_of


@pytest.fixture(scope="session")
def start() -> Callable[..., "subprocess.Popen[str]"]:
    return start_footsel


@pytest.fixture(scope="session")
def config() -> DatasetConfig:
    return CONFIG


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished dataset that nobody changes."""
    return generate(CONFIG, tmp_path_factory.mktemp("finished") / "data", jobs=1).parent


@pytest.fixture
def dataset(finished: Path, tmp_path: Path) -> Path:
    """A copy that a test may change."""
    return Path(shutil.copytree(finished, tmp_path / "data"))
