"""docs/judge.py: maps as `footsel compare` would ask of them, with the oracle's labels."""

from pathlib import Path

import numpy as np

from footsel.comparison.maps import built_in_courses
from footsel.comparison.poses import TILT
from footsel.footholds import BasePose, Reason
from footsel.learning.evaluate import find_models
from footsel.oracle import Oracle
from footsel.runtime.model_folder import find_model_folder


def test_maps_are_those_of_compare_with_labels_of_the_oracle(script, monkeypatch):
    module = script("judge")
    monkeypatch.setattr(module, "POSES", 1)
    (model,) = (found for found in find_models(Path(find_model_folder("anymal_b"))) if found.pair == "front")
    samples = module.as_compared(model)
    courses = built_in_courses(module.SEED)
    assert samples.family.tolist() == [course.name for course in courses]
    assert np.abs(samples.pose[:, 3:5]).max() <= TILT
    for number in (0, 7):
        pose = BasePose(*map(float, samples.pose[number]))
        there = model.layout.local_map(courses[number].elevation_map, pose, "LF")
        # Kept in steps of 0.1 mm, at a place kept in float32.
        np.testing.assert_allclose(samples.heights()[number], there.heights, atol=1e-3)
        reason = Oracle.load("anymal_b").label(there, "LF", pose.roll, pose.pitch).reason
        assert (reason == samples.reason[number]).mean() > 0.99
    assert 0.2 < (samples.reason == Reason.FEASIBLE).mean() < 0.8
