"""The frame: help, exit codes, and errors in one line."""

import re
import subprocess
import sys

import pytest

import footsel as package
from footsel.cli import main as main_module
from footsel.cli import select
from footsel.cli.main import COMMANDS
from footsel.errors import InputError
from footsel.selectors import SELECTORS

#: Options whose help must name a unit or what is counted.
UNITS = {
    "label": ("[m]", "[m, rad]"),
    "select": ("[m]", "[m, rad]"),
    "dataset": ("degrees", "maps per pair"),
    "train": ("CPU threads",),
    "bench": ("ms",),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(footsel, command):
    outcome = footsel(command, "--help")
    assert outcome.code == 0 and outcome.err == ""
    text = " ".join(outcome.out.split())
    assert text.startswith(f"usage: footsel {command}")
    for unit in UNITS.get(command, ()):
        assert unit in text
    # No option without a word on what it is.
    for option in re.findall(r"^  (--[a-z0-9-]+)(?: [^ ]+)*$\n(?!    )", outcome.out, flags=re.MULTILINE):
        pytest.fail(f"{option} of {command} has no help")


def test_help_lists_all_commands(footsel):
    outcome = footsel("--help")
    assert outcome.code == 0
    for command in COMMANDS:
        assert re.search(rf"^ +{command}\s+\w", outcome.out, flags=re.MULTILINE)


def test_help_of_select_names_every_selector(footsel):
    assert sorted(select.SELECTORS) == sorted(SELECTORS)
    text = footsel("select", "--help").out
    for name in SELECTORS:
        assert name in text


def test_version(footsel):
    outcome = footsel("--version")
    assert outcome.code == 0 and outcome.out == f"footsel {package.__version__}\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), ("COMMAND", "footsel --help")),
        (("walk-the-dog",), ("walk-the-dog", "select")),
        (("robots", "--colour"), ("--colour", "footsel robots --help")),
        (("select", "--sel", "cnn"), ("footsel select --help",)),  # No abbreviations.
        (("select", "m.npz"), ("--pose", "footsel select --help")),
        (("dataset",), ("OUT",)),
        (("dataset", "d", "--maps", "0"), ("'0'", "1 or more")),
        (("dataset", "d", "--jobs", "0"), ("'0'", "-1")),
        (("dataset", "d", "--seed", "-3"), ("'-3'", "0 or more")),
        (("dataset", "d", "--legs", "LF"), ("'LF'", "front, hind")),
        (("dataset", "d", "--engine", "dask"), ("--scheduler",)),
        (("dataset", "d", "--scheduler", "tcp://somewhere:1"), ("--engine dask",)),
        (("train", "no/dataset", "run"), ("no/dataset", "footsel dataset")),
        (("train", "no/dataset", "run", "--recipe", "cake"), ("'cake'", "paper, footsel")),
        (("evaluate", "no/model", "no/dataset", "--out", "m.json"), ("no/dataset",)),
        (("export", "no/run", "out"), ("no/run", "footsel train")),
        (("bench", "--model", "no/model"), ("no/model",)),
    ],
)
def test_misuse_is_one_line_and_exit_code_2(footsel, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    assert footsel(*arguments).complains(*words)
    assert list(tmp_path.iterdir()) == []


def raising(error):
    def run(_):
        raise error

    return run


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (InputError("two\nlines", "mend\tit"), 2, "footsel: error: two lines; mend it\n"),
        (PermissionError(13, "Permission denied", "/x/y.npz"), 2, "/x/y.npz: Permission denied"),
        (IsADirectoryError(21, "Is a directory", "/x"), 2, "/x: Is a directory"),
        (OSError(28, "No space left on device"), 2, "No space left on device"),
        (KeyboardInterrupt(), 130, "footsel: interrupted\n"),
    ],
)
def test_exit_codes(footsel, monkeypatch, error, code, message):
    monkeypatch.setattr("footsel.cli.robots.run", raising(error))
    outcome = footsel("robots")
    assert outcome.code == code and message in outcome.err and outcome.err.count("\n") == 1


def test_what_nobody_expected_keeps_its_traceback(footsel, monkeypatch):
    monkeypatch.setattr("footsel.cli.robots.run", raising(ZeroDivisionError()))
    with pytest.raises(ZeroDivisionError):
        footsel("robots")


def test_a_reader_that_leaves_is_no_error():
    """As in `footsel robots | head -0`."""
    process = subprocess.Popen(
        [sys.executable, "-m", main_module.__name__, "robots"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    process.stdout.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait(timeout=60) == main_module.EXIT_NOBODY_READS
