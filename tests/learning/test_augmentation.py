"""Maps as a camera sees them: a share of them, the same for the same seed, labels of the true ground."""

import numpy as np
import pytest

from footsel.dataset.samples import UNKNOWN_HEIGHT
from footsel.footholds import Reason
from footsel.learning.augmentation import MOST_HIDDEN, as_seen
from footsel.terrain.degradation import DRIFT_HEIGHT, drift


def test_the_same_seed_gives_the_same_maps(samples):
    one, again, other = (as_seen(samples, 0.02, 1.0, 1.0, 0.0, seed) for seed in ((1, 2, 3), (1, 2, 3), (1, 2, 4)))
    assert np.array_equal(one.heights_tenth_mm, again.heights_tenth_mm)
    assert not np.array_equal(one.heights_tenth_mm, other.heights_tenth_mm)


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("kind", ["noise", "holes"])
def test_a_share_of_the_maps_is_seen_and_the_others_stay(make_samples, share, kind):
    samples = make_samples(200, 3)
    seen = as_seen(samples, 0.02, **{"noise": 0.0, "holes": 0.0, kind: share}, shift=0.0, seed=(0,))
    changed = (seen.heights_tenth_mm != samples.heights_tenth_mm).any(axis=(1, 2))
    assert changed.mean() == pytest.approx(share, abs=0.1 if 0 < share < 1 else 0)
    for name in ("cost", "reason", "pose", "family", "course"):
        assert np.array_equal(getattr(seen, name)[~changed], getattr(samples, name)[~changed])


def test_noise_hides_nothing_and_holes_move_nothing(samples):
    before = samples.heights_tenth_mm
    noisy, holed = (as_seen(samples, 0.02, *shares, 0.0, (0,)).heights_tenth_mm for shares in ((1.0, 0.0), (0.0, 1.0)))
    assert np.array_equal(noisy == UNKNOWN_HEIGHT, before == UNKNOWN_HEIGHT) and (noisy != before).mean() > 0.8
    assert set(np.unique(holed[holed != before])) == {UNKNOWN_HEIGHT}


def test_a_shift_lifts_all_known_cells_of_a_map_together(make_samples):
    samples = make_samples(300, 4)
    before, after = samples.heights(), as_seen(samples, 0.02, 0.0, 0.0, 0.002, (0,)).heights()
    assert np.array_equal(np.isnan(before), np.isnan(after))
    lifts = np.nanmean(after - before, axis=(1, 2))
    assert np.nanmax(np.abs(after - before - lifts[:, None, None])) < 1.1e-4  # Stored in steps of 0.1 mm.
    assert lifts.std() == pytest.approx(0.002, rel=0.1) and abs(lifts.mean()) < 4e-4


def test_labels_stay_but_for_hidden_cells(samples):
    seen = as_seen(samples, 0.02, 1.0, 1.0, 0.0, (0,))
    before, after = samples.heights_tenth_mm != UNKNOWN_HEIGHT, seen.heights_tenth_mm != UNKNOWN_HEIGHT
    hidden = before & ~after
    assert not (after & ~before).any() and 0 < hidden.mean() < MOST_HIDDEN
    assert (seen.cost[hidden] == 255).all() and (seen.reason[hidden] == Reason.UNKNOWN).all()
    assert np.array_equal(seen.cost[~hidden], samples.cost[~hidden])
    assert np.array_equal(seen.reason[~hidden], samples.reason[~hidden])
    assert (seen.heights_tenth_mm != samples.heights_tenth_mm)[after].mean() > 0.9


def test_drift_is_a_plane_of_the_stated_size():
    planes = np.stack([drift(40, 0.02, np.random.default_rng(seed)) for seed in range(300)])
    for axis in (1, 2):
        np.testing.assert_allclose(np.diff(planes, n=2, axis=axis), 0, atol=1e-6)
    assert planes.mean(axis=(1, 2)).std() == pytest.approx(DRIFT_HEIGHT, rel=0.15)
