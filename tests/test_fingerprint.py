"""Code that decides a label is known by its hash."""

import subprocess
import sys
from pathlib import Path

import pytest

import footsel
from footsel.fingerprint import LABEL_SOURCES, sources_fingerprint

#: Messages, the writing of files, and what a dataset counts besides.
BESIDE = {"errors.py", "files.py", "__init__.py", "dataset"}


@pytest.fixture
def sources(tmp_path):
    (tmp_path / "room" / "inner").mkdir(parents=True)
    (tmp_path / "room" / "inner" / "a.py").write_text("a")
    (tmp_path / "room" / "b.toml").write_text("b")
    (tmp_path / "file.py").write_text("c")
    return tmp_path


@pytest.mark.parametrize("name", ["room/inner/a.py", "room/b.toml", "file.py", "room/new.json"])
def test_every_edit_counts(sources, name):
    before = sources_fingerprint("room", "file.py", root=sources)
    assert sources_fingerprint("room", "file.py", root=sources) == before
    (sources / name).write_text("edited")
    assert sources_fingerprint("room", "file.py", root=sources) != before


def test_what_is_no_source_does_not_count(sources):
    before = sources_fingerprint("room", root=sources)
    (sources / "file.py").write_text("edited")
    (sources / "room" / "a.pyc").write_text("compiled")
    assert sources_fingerprint("room", root=sources) == before


def test_a_new_place_is_an_edit(sources):
    before = sources_fingerprint("room", root=sources)
    (sources / "room" / "inner" / "a.py").rename(sources / "room" / "a.py")
    assert sources_fingerprint("room", root=sources) != before


def test_a_source_that_is_gone_is_an_error(sources):
    with pytest.raises(FileNotFoundError):
        sources_fingerprint("nowhere.py", root=sources)


def test_all_that_a_label_is_made_with_counts():
    code = """
import sys, footsel.dataset.labelling
print(*[module.__file__ for name, module in sys.modules.items() if name.startswith("footsel")])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    package = Path(footsel.__file__).parent
    loaded = {Path(file).relative_to(package).parts[0] for file in done.stdout.split()}
    assert {"oracle", "robot", "terrain", "footholds", "compiled.py"} <= loaded
    assert loaded <= {*LABEL_SOURCES, *BESIDE}
