"""A released folder is loaded whole or not at all."""

import pytest

from footsel.errors import ModelError
from footsel.runtime import FootholdSelector, available_models, model_folder
from footsel.runtime.model_folder import SUMS_FILE, available_variants, find_model_folder, load_networks, sums_text


def seal(folder):
    """Write checksums that fit the folder as it is."""
    contents = {path.name: path.read_bytes() for path in folder.iterdir() if path.name != SUMS_FILE}
    (folder / SUMS_FILE).write_text(sums_text(contents))


def test_a_sound_folder_loads(model_folder):
    networks = load_networks(model_folder)
    assert {pair: network.contract.pair for pair, network in networks.items()} == {"front": "front", "hind": "hind"}
    assert available_variants(model_folder) == ("float32",)


@pytest.mark.parametrize("name", ["front.onnx", "hind.onnx", "model_card.md", "metrics.json", "parity.json"])
def test_a_missing_file_is_named(model_folder, name):
    (model_folder / name).unlink()
    with pytest.raises(ModelError, match=rf"cannot read .*{name} .*; copy or export the whole model folder again"):
        load_networks(model_folder)


@pytest.mark.parametrize("name", ["front.onnx", "hind.onnx", "model_card.md", "metrics.json", "parity.json"])
def test_one_changed_byte_is_noticed(model_folder, name):
    content = bytearray((model_folder / name).read_bytes())
    content[len(content) // 2] ^= 1
    (model_folder / name).write_bytes(content)
    with pytest.raises(ModelError, match=rf"{name} is not the file that was released"):
        load_networks(model_folder)


def test_without_checksums_it_is_no_release(model_folder):
    (model_folder / SUMS_FILE).unlink()
    with pytest.raises(ModelError, match=f"has no {SUMS_FILE}; give a folder written by `footsel export`"):
        load_networks(model_folder)


@pytest.mark.parametrize("line", ["abc", "0" * 64, f"{'0' * 64}  ../front.onnx", f"{'0' * 64}  /etc/hostname"])
def test_damaged_checksums_are_refused(model_folder, line):
    path = model_folder / SUMS_FILE
    path.write_text(path.read_text() + line + "\n")
    with pytest.raises(ModelError, match="damaged line"):
        load_networks(model_folder)


def test_front_and_hind_swapped(model_folder):
    front, hind = (model_folder / f"{pair}.onnx" for pair in ("front", "hind"))
    content = front.read_bytes()
    front.write_bytes(hind.read_bytes())
    hind.write_bytes(content)
    with pytest.raises(ModelError, match="not the file that was released"):
        load_networks(model_folder)
    seal(model_folder)
    with pytest.raises(ModelError, match=r"front network of .* was trained for the hind legs; put front and hind"):
        load_networks(model_folder)


def test_two_robots_in_one_folder(model_folder, handmade, anymal_layout):
    other = handmade.contract(anymal_layout, "hind", robot="hyq")
    (model_folder / "hind.onnx").write_bytes(handmade.random_model(other, 1))
    seal(model_folder)
    with pytest.raises(ModelError, match="mixes robots: front is 'anymal_b', hind is 'hyq'"):
        load_networks(model_folder)


def test_two_layouts_in_one_folder(model_folder, handmade, anymal_layout):
    other = handmade.contract(anymal_layout, "hind", distance_weight=80.0)
    (model_folder / "hind.onnx").write_bytes(handmade.random_model(other, 1))
    seal(model_folder)
    with pytest.raises(ModelError, match="mixes two layouts of 'anymal_b'"):
        load_networks(model_folder)


def test_a_variant_that_is_not_there_lists_those_that_are(model_folder):
    with pytest.raises(ModelError, match=r"does not list front.int8.onnx; variants of this model: float32"):
        load_networks(model_folder, "int8")
    with pytest.raises(ModelError, match="unknown model variant 'int4'; choose from: float32, int8"):
        load_networks(model_folder, "int4")


@pytest.fixture
def roots(tmp_path, monkeypatch):
    """Package data and checkout, both empty."""
    package, checkout = tmp_path / "site" / "models", tmp_path / "checkout" / "export"
    monkeypatch.setattr(model_folder, "MODEL_ROOTS", (package, checkout))
    return package, checkout


def test_names_are_found_in_the_package_first_then_in_the_checkout(roots, handmade, model_files):
    package, checkout = roots
    handmade.write_folder(checkout / "anymal_b", model_files)
    assert find_model_folder("anymal_b") == checkout / "anymal_b"
    assert FootholdSelector.load("anymal_b").robot == "anymal_b"
    handmade.write_folder(package / "anymal_b", model_files)
    assert find_model_folder("anymal_b") == package / "anymal_b"
    assert FootholdSelector.load("anymal_b").robot == "anymal_b"
    assert available_models() == ("anymal_b",)


def test_an_unknown_name_lists_the_models_there_are(roots, handmade, model_files):
    for name in ("anymal_b", "hyq"):
        handmade.write_folder(roots[0] / name, model_files)
    with pytest.raises(ModelError, match=r"no model 'spot'; .*\(available: anymal_b, hyq\)"):
        FootholdSelector.load("spot")


def test_a_file_is_answered_with_its_folder(model_folder):
    with pytest.raises(ModelError, match=f"front.onnx is a file; give the model folder that holds it: {model_folder}"):
        FootholdSelector.load(model_folder / "front.onnx")


def test_the_roots_lie_where_the_wheel_and_the_checkout_keep_models():
    package, checkout = model_folder.MODEL_ROOTS
    assert package.parts[-2:] == ("footsel", "models")
    assert checkout == package.parents[1] / "export"
