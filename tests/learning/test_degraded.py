"""Degraded input, true labels."""

import numpy as np
import pytest

from footsel.dataset.samples import UNKNOWN_HEIGHT
from footsel.errors import InputError, UnknownNameError
from footsel.footholds import Reason
from footsel.footholds.cost import CLASSES
from footsel.learning.degraded import Degradation, degraded
from footsel.learning.evaluate import evaluate


def test_known_cells_keep_their_label_and_lost_ones_have_none(samples):
    worse = degraded(samples, Degradation("d435", 0.2, 3), 0.02)
    lost = worse.heights_tenth_mm == UNKNOWN_HEIGHT
    was_unknown = samples.heights_tenth_mm == UNKNOWN_HEIGHT
    assert (lost | ~was_unknown).all() and 0.15 < (lost & ~was_unknown).mean() <= 0.2
    np.testing.assert_array_equal(worse.reason == Reason.UNKNOWN, lost)
    assert (worse.cost[lost] == 255).all()
    for name in ("cost", "reason"):
        np.testing.assert_array_equal(getattr(worse, name)[~lost], getattr(samples, name)[~lost])
    changed = worse.heights_tenth_mm != samples.heights_tenth_mm
    assert changed[~lost].mean() > 0.9


def test_a_map_s_noise_depends_on_the_seed_and_its_number_alone(samples):
    whole = degraded(samples, Degradation("d435", 0.1, 7), 0.02)
    part = degraded(samples.take(slice(4, 6)), Degradation("d435", 0.1, 7), 0.02, first=4)
    np.testing.assert_array_equal(whole.heights_tenth_mm[4:6], part.heights_tenth_mm)
    other = degraded(samples, Degradation("d435", 0.1, 8), 0.02)
    assert (whole.heights_tenth_mm != other.heights_tenth_mm).mean() > 0.5


def test_a_network_that_trusts_every_cell_still_never_picks_an_unknown_one(samples, layout):
    def careless(samples):
        return np.tile(np.eye(CLASSES, dtype=np.float32)[0][:, None, None], (len(samples), 1, 40, 40))

    picks = evaluate(careless, samples, layout, "LF", 0.5, Degradation(holes=0.9))["all"]["picks"]
    assert picks["picks"] == 10 and picks["unknown_picks"] == 0


def test_nothing_asked_is_nothing_done(samples):
    same = degraded(samples, Degradation(), 0.02)
    for name in ("heights_tenth_mm", "cost", "reason"):
        np.testing.assert_array_equal(getattr(same, name), getattr(samples, name))


@pytest.mark.parametrize("holes", [-0.1, 1.0, float("nan")])
def test_wrong_shares_are_refused(holes):
    with pytest.raises(InputError, match="share of holes"):
        Degradation(holes=holes)


def test_a_camera_that_is_not_known_is_refused():
    with pytest.raises(UnknownNameError, match="d435"):
        Degradation("kinect")
