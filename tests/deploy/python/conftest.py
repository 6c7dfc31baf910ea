"""The files of deploy/python, which users copy, as modules."""

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

DEPLOY = Path(__file__).resolve().parents[3] / "deploy" / "python"


@pytest.fixture
def deployed(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """deployed("grid_map"): a fresh module of deploy/python."""

    def load(name: str) -> ModuleType:
        spec = importlib.util.spec_from_file_location(name, DEPLOY / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, name, module)  # Dataclasses look themselves up there.
        spec.loader.exec_module(module)
        return module

    return load
