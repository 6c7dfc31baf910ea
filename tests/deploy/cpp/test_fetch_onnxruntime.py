"""The root of onnxruntime is refused if its headers and its library do not fit."""

import importlib.util
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[3] / "deploy" / "cpp" / "fetch_onnxruntime.py"


@pytest.fixture
def fetch():
    spec = importlib.util.spec_from_file_location("fetch_onnxruntime", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("version", ["1.29.0", "1.31.1", "1.100.0"])
def test_headers_as_old_as_the_library_or_older(fetch, tmp_path, version):
    (tmp_path / "onnxruntime_c_api.h").write_text("#define ORT_API_VERSION 29\n")
    fetch.check_versions(tmp_path, Path(f"libonnxruntime.so.{version}"))


def test_headers_newer_than_the_library(fetch, tmp_path):
    (tmp_path / "onnxruntime_c_api.h").write_text("#define ORT_API_VERSION 29\n")
    with pytest.raises(fetch.FetchError, match=r"ask for interface 29.*pip install 'onnxruntime>=1.29'"):
        fetch.check_versions(tmp_path, Path("libonnxruntime.so.1.23.2"))


def test_package_without_headers(fetch, tmp_path):
    with pytest.raises(fetch.FetchError, match=r"has no onnxruntime_c_api\.h"):
        fetch.check_versions(tmp_path, Path("libonnxruntime.so.1.31.1"))


def test_the_wheels_library_is_there(fetch):
    assert fetch.wheel_library().is_file()
