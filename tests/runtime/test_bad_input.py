"""What a user may hand in by mistake: a clear error, or the answer all the same; never a crash or a wrong pick."""

import warnings

import numpy as np
import onnx
import pytest

from footsel import ElevationMap
from footsel.errors import InputError, MapError, ModelError
from footsel.footholds import BasePose
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector, Network
from footsel.runtime.model_folder import SUMS_FILE

POSE = (0.1, -0.05, 0.5, 0.05, -0.03, 0.7)


def heights(seed: int = 0, holes: float = 0.1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    elevation = rng.uniform(-0.1, 0.1, (120, 120)).astype(np.float32)
    elevation[rng.random(elevation.shape) < holes] = np.nan
    return elevation


@pytest.fixture(scope="module")
def selector(tmp_path_factory, handmade, anymal_layout):
    files = {
        f"{pair}.onnx": handmade.random_model(handmade.contract(anymal_layout, pair), seed)
        for seed, pair in enumerate(("front", "hind"))
    }
    return FootholdSelector.load(handmade.write_folder(tmp_path_factory.mktemp("bad_input") / "model", files))


@pytest.mark.parametrize(("opset", "ir", "words"), [(99, 10, "Opset 99"), (20, 99, "IR version: 99")])
def test_a_file_of_another_onnxruntime_says_so(handmade, anymal_layout, opset, ir, words):
    model = onnx.load_from_string(handmade.random_model(handmade.contract(anymal_layout), 0))
    model.opset_import[0].version, model.ir_version = opset, ir
    with pytest.raises(ModelError, match=rf"front.onnx is written for another onnxruntime than \S+ \({words}\)"):
        Network.from_bytes(model.SerializeToString(), "front.onnx")


@pytest.mark.parametrize("part", ["raw weights", "metadata"])
def test_a_file_that_still_loads_but_was_tampered_with(model_folder, part):
    path = model_folder / "front.onnx"
    model = onnx.load(path)
    if part == "metadata":
        model.metadata_props[0].value = model.metadata_props[0].value.replace(
            '"feasible_below": 0.2', '"feasible_below": 1'
        )
    else:
        model.graph.initializer[0].raw_data = bytes(len(model.graph.initializer[0].raw_data))
    path.write_bytes(model.SerializeToString())
    Network.load(path)
    with pytest.raises(ModelError, match=rf"front.onnx is not the file that was released .*{SUMS_FILE}"):
        FootholdSelector.load(model_folder)


def test_a_model_without_its_decoding_says_what_is_missing(handmade, anymal_layout):
    from footsel.exporting.decoding import without_decoding

    model = without_decoding(onnx.load_from_string(handmade.random_model(handmade.contract(anymal_layout), 0)))
    with pytest.raises(ModelError, match=r"outputs .* its contract says float tensors .* infeasible \[n, 40, 40\]"):
        Network.from_bytes(model.SerializeToString(), "front.onnx")


@pytest.mark.parametrize("index", range(6))
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e300])
def test_a_pose_that_is_not_finite(selector, index, value):
    """Also one that was made by hand, not read from numbers."""
    numbers = list(POSE)
    numbers[index] = value
    elevation_map = ElevationMap(heights(), 0.02)
    for pose in (numbers, BasePose(*numbers)):
        with pytest.raises(InputError, match=r"base pose is .*; give six finite numbers"):
            selector.select(elevation_map, pose)
    with pytest.raises(InputError, match=r"base pose 1 is .*; give finite numbers"):
        selector.select_many(elevation_map, [POSE, numbers])


@pytest.mark.parametrize("same", [
    lambda e: e.astype(np.float64),
    lambda e: e.astype(">f4"),
    np.asfortranarray,
    lambda e: np.ascontiguousarray(e[::-1])[::-1],
    lambda e: np.repeat(e, 2, axis=1)[:, ::2],
    lambda e: e.tolist(),
    np.ma.masked_array,
])  # fmt: skip
def test_any_memory_layout_and_type_gives_the_same_answer(selector, same):
    expected = selector.select(ElevationMap(heights(), 0.02), POSE)
    assert selector.select(ElevationMap(same(heights()), 0.02), POSE) == expected


def test_nothing_of_the_caller_is_written_to(selector):
    """Read-only arrays are enough, and stay as they are."""
    elevation, local, pose = heights(), heights()[:40, :40].copy(), np.array(POSE)
    before = elevation.copy(), local.copy(), pose.copy()
    for array in (elevation, local, pose):
        array.setflags(write=False)
    elevation_map = ElevationMap(elevation, 0.02)
    selector.select(elevation_map, pose, previous=selector.select(elevation_map, pose), top_k=3)
    selector.select_many(elevation_map, pose[None])
    for leg in LEGS:
        selector.evaluate(local, leg, np.array([0.1]), 0.0)
    for array, copy in zip((elevation, local, pose), before, strict=True):
        np.testing.assert_array_equal(array, copy)


@pytest.mark.parametrize("shape", [(2, 2), (2, 120), (5, 5)])
def test_a_map_smaller_than_a_local_map_is_answered(selector, shape):
    """What lies beyond is unknown; nothing is picked there."""
    elevation_map = ElevationMap(np.zeros(shape), 0.02)
    for foothold in selector.select(elevation_map, (0, 0, 0.5, 0, 0, 0)).values():
        if foothold.status == "ok":
            assert elevation_map.contains(foothold.position[:2])
        else:
            assert foothold.reason


@pytest.mark.parametrize("resolution", [1e-300, 1e-6, 1e4, 1e300])
def test_cells_of_no_size_a_leg_can_use(selector, resolution):
    with pytest.raises(MapError, match=r"the map's cells are .* m wide; give its resolution in metres"):
        selector.select(ElevationMap(np.zeros((50, 50)), resolution), (0, 0, 0.5, 0, 0, 0))


def test_a_map_beyond_the_world(selector):
    """Arithmetic with its position would overflow."""
    with pytest.raises(MapError, match=r"the map's centre is at .*; give its position in metres"):
        selector.select(ElevationMap(np.zeros((50, 50)), 0.02, (0, 1e306)), (0, 0, 0.5, 0, 0, 0))


def test_millimetres_and_centimetres_are_noticed_once(model_folder):
    for factor in (1000, 100):
        selector = FootholdSelector.load(model_folder)
        wrong = ElevationMap((heights(holes=0.3) - 0.6) * factor, 0.02)
        with pytest.warns(UserWarning, match="above or below the hips: is the elevation map in metres") as caught:
            selector.select(wrong, POSE)
        assert caught[0].filename == __file__
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            selector.select(wrong, POSE)


def test_steep_sparse_and_unknown_maps_are_not_suspected(selector):
    cliff = heights()
    cliff[:60] -= 30
    one = np.full((120, 120), np.nan)
    one[60, 60] = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for elevation in (cliff, heights() * 20, one, np.full((120, 120), np.nan)):
            selector.select(ElevationMap(elevation, 0.02), POSE)


@pytest.mark.parametrize("count", [7, 8, 9, 20])
def test_evaluate_takes_any_number_of_maps(selector, count):
    """More than one batch: each map is answered as alone."""
    local = np.random.default_rng(count).uniform(-0.8, -0.2, (count, 40, 40))
    roll = np.linspace(-0.2, 0.2, count)
    together = selector.evaluate(local, "RH", roll, 0.1)
    for number in range(count):
        alone = selector.evaluate(local[number], "RH", roll[number], 0.1)
        for name in ("class_", "cost", "feasible", "confidence"):
            np.testing.assert_allclose(getattr(together, name)[number], getattr(alone, name), atol=1e-3)
