"""select_many in C++: what `select` says of each pose, and what Python's select_many says."""

import json

import numpy as np
import pytest

from footsel import ElevationMap
from footsel.legs import LEGS
from footsel.runtime import FootholdSelector
from footsel.terrain.courses import make_course

POSES = 11


@pytest.fixture(scope="module")
def ground():
    """Stones with holes, so that some legs find nothing."""
    course = make_course("stones", 3, 3.0)
    elevation = course.elevation.copy()
    elevation[np.random.default_rng(0).random(elevation.shape) < 0.1] = np.nan
    elevation[:50] = np.nan
    return ElevationMap(elevation, course.resolution)


@pytest.fixture(scope="module")
def poses():
    rng = np.random.default_rng(1)
    xy, z = rng.uniform(-1.0, 1.4, (POSES, 2)), rng.uniform(0.4, 0.55, (POSES, 1))
    return np.hstack([xy, z, rng.uniform(-0.15, 0.15, (POSES, 2)), rng.uniform(-3, 3, (POSES, 1))])


def by_cpp(cpp, released, case, poses, own=None):
    data = case.to_bytes() + poses.astype("<f8").tobytes() + (b"" if own is None else own.astype("<f8").tobytes())
    done = cpp.run("many_poses", released, len(poses), int(own is not None), data=data)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("legs", [LEGS, ("RF",), ("LF", "LH", "RH")])
@pytest.mark.parametrize("count", [0, 1, POSES])
def test_the_same_footholds_as_in_python(cpp, released, case, ground, poses, legs, count):
    poses = poses[:count]
    *found, best = by_cpp(cpp, released, case(ground, (0, 0, 0.5, 0, 0, 0), legs), poses)
    expected = FootholdSelector.load(released).select_many(ground, poses, legs)
    assert len(found) == count
    for number, each in enumerate(found):
        for leg, foothold in each["footholds"].items():
            at = number, expected.legs.index(leg)
            assert (foothold["status"] == "ok") == expected.found[at]
            assert foothold["nominal"] == pytest.approx(expected.nominal[at], abs=1e-6)
            if foothold["status"] == "ok":
                assert foothold["cell"] == expected.cells[at].tolist()
                assert foothold["position"] == pytest.approx(expected.positions[at], abs=1e-5)
                assert foothold["final_cost"] == pytest.approx(expected.final_costs[at], abs=1e-3)
        cost = np.inf if each["pose_cost"] is None else each["pose_cost"]
        assert cost == pytest.approx(expected.pose_costs[number], abs=4e-3)
    assert best == (-1 if expected.best_pose() is None else expected.best_pose())
    if count == POSES:
        assert 0 < expected.found.sum() < expected.found.size


def test_each_pose_is_answered_as_by_itself(cpp, released, case, ground, poses):
    """With everything that `select` can be asked for."""
    options = {"top_k": 3, "max_distance": 0.25, "verify": 2, "previous": {"LF": (0.5, 0.3)}, "hysteresis": 20.0}
    *many, _ = by_cpp(cpp, released, case(ground, (0, 0, 0.5, 0, 0, 0), **options), poses)
    alone = cpp.select(released, [case(ground, tuple(pose), **options) for pose in poses.tolist()])
    for one, other in zip(many, alone, strict=True):
        for leg in LEGS:
            here, there = one["footholds"][leg], other["footholds"][leg]
            assert (here["status"], here["reason"], here["cell"]) == (there["status"], there["reason"], there["cell"])
            assert len(here["alternatives"]) == len(there["alternatives"])


def test_a_nominal_foothold_for_each_pose(cpp, released, case, ground, poses):
    own = poses[:, :2] + np.random.default_rng(2).normal(0, 0.3, (POSES, 2))
    *found, _ = by_cpp(cpp, released, case(ground, (0, 0, 0.5, 0, 0, 0), ("LF", "RF")), poses, own)
    expected = FootholdSelector.load(released).select_many(ground, poses, ("LF", "RF"), {"LF": own})
    for number, each in enumerate(found):
        assert each["footholds"]["LF"]["nominal"][:2] == pytest.approx(own[number])
        assert each["footholds"]["RF"]["nominal"] == pytest.approx(expected.nominal[number, 1], abs=1e-6)
        assert (each["footholds"]["LF"]["status"] == "ok") == expected.found[number, 0]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((7, 0, np.nan), "pose 7: base pose is [nan"),
        ((3, 0, 50.0), "pose 3: the base at x=50"),
    ],
)
def test_a_pose_that_makes_no_sense_is_named(cpp, released, case, ground, poses, change, words):
    row, column, value = change
    poses = poses.copy()
    poses[row, column] = value
    assert words in by_cpp(cpp, released, case(ground, (0, 0, 0.5, 0, 0, 0)), poses)["error"]
    own = np.zeros((POSES, 2))
    own[2, 1] = np.inf
    poses[row, column] = 0.0
    error = by_cpp(cpp, released, case(ground, (0, 0, 0.5, 0, 0, 0)), poses, own)["error"]
    assert error.startswith("pose 2: nominal foothold of LF is (0, inf, 0)")
