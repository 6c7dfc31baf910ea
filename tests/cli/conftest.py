"""A command line run inside the test's process, and small maps to run it on."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.cli.main import main


@dataclass(frozen=True)
class Outcome:
    """What a command left behind."""

    code: int
    out: str
    err: str

    def complains(self, *words: str) -> bool:
        """Exit code 2, nothing on stdout, one line on stderr that has all the words."""
        assert self.code == 2, self
        assert self.out == ""
        assert self.err.startswith("footsel: error: ") and self.err.count("\n") == 1, self.err
        for word in words:
            assert word in self.err
        return True


@pytest.fixture
def footsel(capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """footsel("select", map_path, ...) -> Outcome."""

    def run(*arguments: object) -> Outcome:
        capsys.readouterr()
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as stop:  # argparse leaves so after --help and --version.
            code = stop.code
        captured = capsys.readouterr()
        return Outcome(code, captured.out, captured.err)

    return run


@pytest.fixture
def bumpy_map(tmp_path: Path) -> Path:
    """3 m of gentle waves around 0.1 m, with a hole in a corner and one under a right hind leg."""
    along = np.linspace(0, 12, 150)
    elevation = 0.1 + 0.02 * np.sin(along)[:, None] * np.cos(along)[None, :]
    elevation[:30, :30] = np.nan
    elevation[80:86, 45:52] = np.nan
    ElevationMap(elevation, 0.02).save(tmp_path / "bumpy.npz")
    return tmp_path / "bumpy.npz"


@pytest.fixture
def level_pose() -> tuple[str, ...]:
    return ("--pose", "0", "0", "auto", "0", "0", "0")
