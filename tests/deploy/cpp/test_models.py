"""Which models C++ takes, and what it says of the others."""

import json
import re
import shutil

import numpy as np
import onnx
import pytest

from footsel.footholds import LegLayout
from footsel.runtime.contract import METADATA_KEY
from footsel.runtime.model_folder import SUMS_FILE, checksum


def rewrite(path, change):
    """Let `change` alter an ONNX file's contract, and write it without checking anything."""
    model = onnx.load(path)
    values = json.loads(next(entry.value for entry in model.metadata_props if entry.key == METADATA_KEY))
    change(values)
    del model.metadata_props[:]
    model.metadata_props.add(key=METADATA_KEY, value=json.dumps(values))
    path.write_bytes(model.SerializeToString())


def pair(folder):
    return folder / "front.onnx", folder / "hind.onnx"


def test_released_model_is_taken_whole_and_by_its_two_files(cpp, released):
    assert cpp.select(released, ()) == cpp.select(pair(released), ()) == []


def test_changed_file_is_refused_by_its_checksum_alone(cpp, model_folder):
    rewrite(model_folder / "hind.onnx", lambda values: values.update(commit="1" * 40))
    error = cpp.load_error(model_folder)
    assert "hind.onnx is not the file that was released (its SHA-256 differs from SHA256SUMS)" in error
    assert cpp.select(pair(model_folder), ()) == []


@pytest.mark.parametrize("kept", [0, 1, 100, 0.5, 0.99])
def test_truncated_file(cpp, model_folder, kept):
    path = model_folder / "front.onnx"
    content = path.read_bytes()
    path.write_bytes(content[: kept if isinstance(kept, int) else int(len(content) * kept)])
    assert "SHA-256 differs" in cpp.load_error(model_folder)
    error = cpp.load_error(pair(model_folder))
    assert re.search("front.onnx.*(damaged|no footsel contract|cannot read)", error)
    assert "\n" not in error


def test_file_that_is_no_model(cpp, model_folder):
    (model_folder / "front.onnx").write_text("hello")
    assert "front.onnx is damaged or no ONNX model" in cpp.load_error(pair(model_folder))


@pytest.mark.parametrize("name", ["nowhere", "front.onnx", ""])
def test_folder_that_is_none(cpp, model_folder, name):
    error = cpp.load_error(model_folder / name if name else model_folder.parent)
    assert f"has no {SUMS_FILE}; give a folder written by `footsel export`" in error


def test_missing_network(cpp, model_folder):
    (model_folder / "front.onnx").unlink()
    assert "cannot read" in cpp.load_error(model_folder)
    (model_folder / "front.onnx").mkdir()
    assert "cannot read" in cpp.load_error(model_folder)


def test_variant_that_the_folder_lacks(cpp, model_folder):
    assert f"{SUMS_FILE} does not list front.int8.onnx" in cpp.load_error(model_folder, "--int8")


def test_model_without_a_contract(cpp, handmade, tmp_path):
    path = tmp_path / "plain.onnx"
    path.write_bytes(handmade.convolution_model(np.zeros((14, 4, 1, 1)), np.zeros(14), {}))
    assert "plain.onnx carries no footsel contract" in cpp.load_error((path, path))


def test_contract_of_another_schema(cpp, model_folder):
    rewrite(model_folder / "front.onnx", lambda values: values.update(schema=99))
    assert "has contract schema 99, this footsel reads 2; export the model again" in cpp.load_error(pair(model_folder))


FIELDS = {
    "robot": 7,
    "pair": "middle",
    "leg": "RF",
    "frame": "that of the ship",
    "classes": 13,
    "feasible_below": 0.0,
    "distance_weight": -1.0,
    "opset": 3,
    "layout": [],
    "encoding": None,
    "recipe": None,
    "commit": {},
}


@pytest.mark.parametrize("name", [*FIELDS, "schema"])
def test_contract_without_a_field_or_with_nonsense_in_it(cpp, model_folder, name):
    path = model_folder / "front.onnx"
    released = path.read_bytes()
    rewrite(path, lambda values: values.pop(name))
    assert f'whose "{name}" is missing or makes no sense' in cpp.load_error(pair(model_folder))
    if name in FIELDS:
        path.write_bytes(released)
        rewrite(path, lambda values: values.update({name: FIELDS[name]}))
        assert "is missing or makes no sense" in cpp.load_error(pair(model_folder))


def test_contract_that_is_no_json(cpp, handmade, tmp_path):
    path = tmp_path / "model.onnx"
    path.write_bytes(handmade.convolution_model(np.zeros((14, 4, 1, 1)), np.zeros(14), {METADATA_KEY: '{"schema": 2'}))
    assert "damaged footsel contract" in cpp.load_error((path, path))


def test_graph_that_is_not_what_its_contract_says(cpp, model_folder):
    path = model_folder / "front.onnx"
    rewrite(path, lambda values: values["encoding"].update(planes=["height", "unknown"]))
    error = cpp.load_error(pair(model_folder))
    assert "front.onnx has other inputs or outputs than its contract says: float tensors maps [n, 2, 40, 40]" in error


def test_graph_without_decoding(cpp, handmade, anymal_layout, tmp_path):
    """Fourteen classes of 30x30 cells, which the test's maker leaves undecoded."""
    path = tmp_path / "model.onnx"
    metadata = {METADATA_KEY: handmade.contract(anymal_layout).to_json()}
    path.write_bytes(handmade.convolution_model(np.zeros((14, 4, 1, 1)), np.zeros(14), metadata, cells=30))
    assert "has other inputs or outputs" in cpp.load_error((path, path))


def test_opset_that_onnxruntime_lacks(cpp, model_folder):
    path = model_folder / "front.onnx"
    model = onnx.load(path)
    model.opset_import[0].version = 999
    path.write_bytes(model.SerializeToString())
    assert re.search(r"front.onnx is written for another onnxruntime than 1\.", cpp.load_error(pair(model_folder)))


def test_front_and_hind_swapped(cpp, model_folder):
    front, hind = pair(model_folder)
    assert "was trained for the hind legs" in cpp.load_error((hind, front))


def test_networks_that_do_not_belong_together(cpp, handmade, anymal_layout, model_folder):
    front, hind = pair(model_folder)
    hind.write_bytes(handmade.constant_model(handmade.contract(anymal_layout, "hind", robot="other")))
    assert "mixes robots: front is 'anymal_b', hind is 'other'" in cpp.load_error((front, hind))
    finer = LegLayout.from_dict({**anymal_layout.to_dict(), "resolution": 0.01})
    hind.write_bytes(handmade.constant_model(handmade.contract(finer, "hind")))
    assert "mixes two layouts of 'anymal_b'" in cpp.load_error((front, hind))


def test_model_of_another_robot(cpp, model_folder):
    assert cpp.select(model_folder, (), "--robot", "anymal_b") == []
    assert "is a model of 'anymal_b', not of 'go1'" in cpp.load_error(model_folder, "--robot", "go1")


def test_int8_variant(cpp, handmade, anymal_layout, tmp_path, case):
    """Another file of the same folder: networks that say another class everywhere."""
    files = {}
    for name, class_ in ((".onnx", 0), (".int8.onnx", 5)):
        for which in ("front", "hind"):
            files[which + name] = handmade.constant_model(handmade.contract(anymal_layout, which), class_)
    folder = handmade.write_folder(tmp_path / "both", files)
    flat = case(None, (0, 0, 0.48, 0, 0, 0), ("LF",), raw=(np.zeros((100, 100), np.float32), 0.02, (0.0, 0.0)))
    classes = [cpp.select(folder, [flat], *options)[0]["footholds"]["LF"]["class"] for options in ((), ("--int8",))]
    assert classes[0] < classes[1]


def test_checksums_may_list_more_files_than_a_robot_has(cpp, model_folder, tmp_path):
    """On a robot the two networks and SHA256SUMS are enough."""
    folder = tmp_path / "robot"
    folder.mkdir()
    for name in ("front.onnx", "hind.onnx", SUMS_FILE):
        shutil.copy(model_folder / name, folder)
    assert cpp.select(folder, ()) == []


@pytest.mark.parametrize("size", [0, 1, 55, 56, 63, 64, 65, 119, 120, 1000])
def test_sha256(cpp, size):
    content = bytes(np.random.default_rng(size).integers(0, 256, size, dtype=np.uint8))
    assert cpp.run("parts", "sha256", data=content).stdout.decode().strip() == checksum(content)


@pytest.mark.parametrize(
    "text",
    [
        "null",
        " true ",
        "-0.5e-3",
        "1E5",
        '"\\u00e9\\ud83d\\ude00 \\"\\\\\\/\\n"',
        "[]",
        "{}",
        '[1, [2, [3]], {"a": [true, false]}]',
        '{"a": {"b": "x"}, "b": "\u00e4"}',
        '{"a": 1, "a": 2}',
    ],
)
def test_json_means_what_python_says(cpp, text):
    def shown(value):
        """As the driver writes: booleans as words."""
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, list):
            return [shown(element) for element in value]
        return {key: shown(member) for key, member in value.items()} if isinstance(value, dict) else value

    done = cpp.run("parts", "json", data=text.encode())
    assert json.loads(done.stdout) == shown(json.loads(text))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "nul",
        "01",
        "1.",
        ".5",
        "+1",
        "1e",
        "-",
        "NaN",
        "1e999",
        "[1,]",
        "[1 2]",
        "{a: 1}",
        '{"a"}',
        '{"a": 1,}',
        "[",
        '"',
        '"\\x"',
        '"\\u12"',
        '"\\ud83d"',
        '"\\udc00"',
        '"\n"',
        "1 2",
        "[" * 100 + "]" * 100,
    ],
)
def test_what_is_no_json(cpp, text):
    done = cpp.run("parts", "json", data=text.encode())
    assert (done.returncode, done.stdout) == (1, b"no JSON\n")
