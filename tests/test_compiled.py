"""Compiled code on disk: as fresh as the sources, and quick to come back."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "footsel"

CALLER = """
from {decorator_from} import {decorator}
from footsel.callee import LIMIT, inner

@{decorated}
def outer(x):
    return min(inner(x), LIMIT)

print(outer(1.0), sum(outer.stats.cache_hits.values()))
"""
CALLEE = """
from footsel.compiled import compiled

LIMIT = {limit}

@compiled
def inner(x):
    return x + {added}
"""
OURS = {"decorator_from": "footsel.compiled", "decorator": "compiled", "decorated": "compiled"}
NUMBAS = {"decorator_from": "numba", "decorator": "njit", "decorated": "njit(cache=True)"}
DECORATORS = {"compiled", "inlined", "numba.njit", "numba.njit(cache=True)"}


@pytest.fixture
def small_package(tmp_path):
    """A package of our name with two modules that call each other; (its folder, what runs it)."""
    folder = tmp_path / "footsel"
    folder.mkdir()
    (folder / "__init__.py").touch()
    for name in ("compiled.py", "files.py", "errors.py"):
        (folder / name).write_bytes((PACKAGE / name).read_bytes())

    def run(added, limit=9.0, decorator=OURS, cache=tmp_path / "cache", **environment):
        (folder / "caller.py").write_text(CALLER.format(**decorator))
        (folder / "callee.py").write_text(CALLEE.format(added=added, limit=limit))
        kept = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
        done = subprocess.run(
            [sys.executable, "-m", "footsel.caller"],
            env={**kept, "PYTHONPATH": str(tmp_path), "FOOTSEL_CACHE": str(cache), **environment},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr
        value, hits = done.stdout.split()
        return float(value), int(hits)

    return folder, run


def test_an_edit_of_what_is_called_reaches_its_caller(small_package):
    _, run = small_package
    assert run(added=1) == (2.0, 0)
    assert run(added=1) == (2.0, 1)  # From disk.
    assert run(added=2) == (3.0, 0)
    assert run(added=2, limit=2.5) == (2.5, 0)
    assert run(added=1) == (2.0, 1)  # As at first.


def test_numba_alone_would_keep_the_old_code(small_package):
    """What this is all about; if numba learns it, ours can go."""
    _, run = small_package
    assert run(added=1, decorator=NUMBAS)[0] == 2.0
    assert run(added=2, decorator=NUMBAS)[0] == 2.0


def test_numbas_own_setting_is_kept(small_package, tmp_path):
    _, run = small_package
    run(added=1, NUMBA_CACHE_DIR=str(tmp_path / "chosen"))
    assert list((tmp_path / "chosen").rglob("*.nbc")) and not (tmp_path / "cache").exists()


def test_without_a_place_to_keep_it_code_is_compiled_each_time(small_package, tmp_path):
    folder, run = small_package
    (tmp_path / "file").touch()
    for added in (1, 2):
        assert run(added=added, cache=tmp_path / "file") == (1.0 + added, 0)
    assert not list(folder.rglob("*.nb[ic]"))


def sources():
    """Files with compiled functions: path -> (syntax tree, whether they use our decorator)."""
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if "footsel.compiled" in text or "numba.njit" in text:
            yield path, ast.parse(text), "footsel.compiled" in text


def test_compiled_code_depends_on_nothing_but_compiled_files():
    """What a compiled function takes from another file is compiled into it, so that file must count as well."""
    counted = {path for path, _, ours in sources() if ours}
    assert len(counted) >= 5
    for path, tree, ours in sources():
        origin = {
            name.asname or name.name: PACKAGE.parent.joinpath(*node.module.split(".")).with_suffix(".py")
            for node in tree.body
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("footsel.")
            for name in node.names
        }
        for function in tree.body:
            if isinstance(function, ast.FunctionDef) and DECORATORS & {ast.unparse(d) for d in function.decorator_list}:
                body = (node for statement in function.body for node in ast.walk(statement))
                used = {node.id for node in body if isinstance(node, ast.Name)} & origin.keys()
                for name in used:
                    assert ours and origin[name] in counted, f"{function.name} of {path} takes {name} from elsewhere"
