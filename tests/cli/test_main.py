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


def test_the_fit_of_the_terrain_cost_has_help(footsel):
    outcome = footsel("terrain-cost", "fit", "--help")
    assert outcome.code == 0 and outcome.err == ""
    for words in ("--seed SEED", "--jobs N", "--robot ROBOT", "placements of a foot"):
        assert words in outcome.out


def test_a_file_in_the_place_of_a_folder_is_named(footsel, tmp_path):
    (tmp_path / "file").touch()
    for command in (("dataset",), ("terrain-cost", "fit")):
        assert footsel(*command, tmp_path / "file").complains(f"OUT: {tmp_path / 'file'} is a file", "give a folder")


def test_folders_of_other_things_are_refused(footsel, tmp_path):
    (tmp_path / "letter").touch()
    for command in (("dataset",), ("terrain-cost", "fit")):
        assert footsel(*command, tmp_path, "--jobs", "1").complains("is not empty", "choose another folder")
    assert [path.name for path in tmp_path.iterdir()] == ["letter"]


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
        (("dataset", "d", "--maps", "0"), ("--maps: '0'", "1 or more")),
        (("dataset", "d", "--maps", "1e3"), ("--maps: '1e3'", "1 or more")),
        (("dataset", "d", "--maps-per-shard", "0"), ("--maps-per-shard: '0'", "1 or more")),
        (("dataset", "d", "--jobs", "0"), ("--jobs: '0'", "-1")),
        (("dataset", "d", "--jobs", "-2"), ("--jobs: '-2'", "-1")),
        (("dataset", "d", "--seed", "-3"), ("--seed: '-3'", "0 or more")),
        (("dataset", "d", "--legs", "LF"), ("--legs: ", "'LF'", "front, hind")),
        (("dataset", "d", "--recipe", "cake"), ("'cake'", "paper, footsel")),
        (("dataset", "d", "--families", "flat", "lava"), ("'lava'", "stairs")),
        (("dataset", "d", "--exclude", "lava"), ("'lava'", "stairs")),
        (("dataset", "d", "--families", "flat", "--exclude", "flat"), ("no terrain family is left",)),
        (("dataset", "d", "--engine", "dask"), ("--scheduler",)),
        (("dataset", "d", "--scheduler", "tcp://somewhere:1"), ("--engine dask",)),
        (("train", "no/dataset", "run"), ("no/dataset", "footsel dataset")),
        (("train", "no/dataset", "run", "--recipe", "cake"), ("'cake'", "paper, footsel")),
        (("evaluate", "no/model", "no/dataset", "--out", "m.json"), ("no/dataset",)),
        (("export", "no/run", "out"), ("no/run", "footsel train")),
        (("bench", "--model", "no/model"), ("no/model",)),
        (("bench", "--calls", "few"), ("--calls: 'few'", "1 or more")),
        (("bench", "--out", "no/folder/b.json"), ("--out: no/folder", "make it first")),
        (("bench", "--robot", "spot"), ("--robot: ", "'spot'", "anymal_b")),
        (("terrain-cost",), ("ACTION", "footsel terrain-cost --help")),
        (("terrain-cost", "bake"), ("'bake'", "fit")),
        (("terrain-cost", "fit"), ("OUT", "footsel terrain-cost fit --help")),
        (("terrain-cost", "fit", "o", "--colour"), ("--colour", "footsel terrain-cost fit --help")),
        (("terrain-cost", "fit", "o", "--placements", "0"), ("--placements: '0'", "1 or more")),
        (("terrain-cost", "fit", "o", "--held-out", "-1"), ("--held-out: '-1'", "1 or more")),
        (("terrain-cost", "fit", "o", "--jobs", "-3"), ("--jobs: '-3'", "-1")),
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
