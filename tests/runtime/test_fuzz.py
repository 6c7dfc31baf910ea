"""Anything at all handed to the runtime is refused in words or answered soundly: no crash, no warning, no wild pick."""

import warnings

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from footsel import ElevationMap, FootselError
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector


@pytest.fixture(scope="module")
def selector(tmp_path_factory, handmade, anymal_layout):
    files = {
        f"{pair}.onnx": handmade.random_model(handmade.contract(anymal_layout, pair, feasible_below=0.5), seed)
        for seed, pair in enumerate(("front", "hind"))
    }
    return FootholdSelector.load(handmade.write_folder(tmp_path_factory.mktemp("fuzz") / "model", files))


numbers = st.one_of(
    st.floats(width=64),
    st.floats(-1, 1),
    st.sampled_from([0.0, -0.0, 0.02, 1e-5, 1e3, 1e9, -1e9, 1e30, 1e-300, 3e38, -3e38]),
)
dtypes = st.sampled_from(["f4", "f8", ">f4", "f2", "i4", "u1", "?", "O", "c8", "U3"])


@st.composite
def arrays(draw, shape):
    """Of any type, order and value, with as many distinct values as an example is long."""
    values = draw(st.lists(numbers, min_size=1, max_size=8))
    seed = draw(st.integers(0, 2**32 - 1))
    array = np.random.default_rng(seed).choice(np.array(values), shape)
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        array = array.astype(draw(dtypes))
    order = draw(st.sampled_from(["C", "F", "reversed", "strided"]))
    if order == "F":
        array = np.asfortranarray(array)
    elif order == "reversed" and array.ndim:
        array = array[::-1]
    elif order == "strided" and array.ndim:
        array = np.repeat(array, 2, axis=-1)[..., ::2]
    array.setflags(write=False)
    return array


side = st.integers(0, 60)
points = st.one_of(st.none(), st.tuples(numbers, numbers), st.tuples(numbers, numbers, numbers), st.text(max_size=2))
legs = st.one_of(st.just(LEGS), st.lists(st.sampled_from([*LEGS, "FL", ""]), max_size=5))


@st.composite
def requests(draw):
    """A map, most often a sound one, and arguments of `select`."""
    resolution = draw(st.one_of(st.sampled_from([0.01, 0.02, 0.05]), numbers))
    terrain = draw(st.one_of(arrays((draw(side), draw(side))), arrays((50, 60)), arrays(())))
    position = draw(st.one_of(st.just((0.0, 0.0)), st.tuples(numbers, numbers)))
    pose = draw(st.one_of(
        st.tuples(*[st.floats(-0.4, 0.4)] * 6), st.lists(numbers, min_size=6, max_size=6), st.lists(numbers, max_size=7)
    ))  # fmt: skip
    options = draw(st.fixed_dictionaries({}, optional={
        "nominal": st.dictionaries(st.sampled_from([*LEGS, "??"]), points, max_size=2),
        "previous": st.dictionaries(st.sampled_from([*LEGS, "??"]), points, max_size=2),
        "top_k": st.sampled_from([1, 3, 1600, 0, -1, 1.5, "2", None]),
        "hysteresis": numbers,
        "max_distance": st.one_of(st.none(), numbers),
        "verify": st.sampled_from([None, lambda *_: True, lambda *_: False]),
    }))  # fmt: skip
    return (terrain, resolution, position), pose, draw(legs), options


def check_select(selector, request):
    terrain, pose, asked, options = request
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message="the terrain under the legs", category=UserWarning)
        try:
            elevation_map = ElevationMap(*terrain)
            footholds = selector.select(elevation_map, pose, asked, **options)
        except FootselError as error:
            assert "\n" not in str(error)
            return
    assert tuple(footholds) == tuple(dict.fromkeys(asked))
    for foothold in footholds.values():
        assert np.isfinite(foothold.nominal).all()
        assert (foothold.status == "ok") == (foothold.reason is None) == (foothold.position is not None)
        if foothold.status == "ok":
            assert np.isfinite([*foothold.position, foothold.cost, foothold.final_cost]).all()
            assert 0 <= foothold.cost <= 255.001 and 0 <= foothold.class_ <= 12 and 0.5 < foothold.confidence <= 1
            assert all(0 <= index < 40 for index in foothold.cell)
            limit = options.get("max_distance")
            assert limit is None or foothold.distance_to_nominal <= limit


def check_evaluate(selector, local, leg, roll, pitch):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            cells = selector.evaluate(local, leg, roll, pitch)
        except FootselError as error:
            assert "\n" not in str(error)
            return
    known = ~np.isnan(np.asarray(local, dtype=np.float64))
    assert not cells.feasible[~known].any()
    assert (cells.cost[~cells.feasible] == 255).all() and (cells.class_[~cells.feasible] == 13).all()
    assert np.isfinite(cells.cost[cells.feasible]).all()


maps = st.sampled_from([(40, 40), (1, 40, 40), (3, 40, 40), (40, 41), (0, 40, 40), ()]).flatmap(arrays)
tilts = st.one_of(st.floats(-1, 1), numbers, st.lists(numbers, max_size=4), st.text(max_size=2))
evaluations = st.tuples(maps, st.sampled_from([*LEGS, "FL"]), tilts, tilts)
FEW = settings(deadline=None, max_examples=250, suppress_health_check=list(HealthCheck))
MANY = settings(FEW, max_examples=10_000)


@FEW
@given(requests())
def test_select_takes_anything(selector, request):
    check_select(selector, request)


@FEW
@given(evaluations)
def test_evaluate_takes_anything(selector, arguments):
    check_evaluate(selector, *arguments)


@pytest.mark.slow
@MANY
@given(requests())
def test_select_takes_ten_thousand_things(selector, request):
    check_select(selector, request)


@pytest.mark.slow
@MANY
@given(evaluations)
def test_evaluate_takes_ten_thousand_things(selector, arguments):
    check_evaluate(selector, *arguments)
