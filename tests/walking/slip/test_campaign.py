"""A small campaign: the same trials for any number of jobs, killed anywhere, and other trials for another seed."""

from dataclasses import fields, replace

import joblib
import numpy as np
import pytest

from footsel.errors import InputError
from footsel.terrain.courses import FAMILIES, make_course
from footsel.walking.slip import campaign
from footsel.walking.slip.campaign import FRICTIONS, PATCH, CampaignConfig, Trials, draw_cells, run_campaign
from footsel.walking.slip.shapes import SHAPES
from footsel.walking.slip.trial import DIRECTIONS, SLIP_CAP

CONFIG = CampaignConfig(placements=48, held_out=24)
#: Two courses to fit and one held out, of each of three families and of the shapes.
FEW = {name: FAMILIES[name] for name in ("flat", "steps", "rubble")}
PER_COURSE = 6


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setattr(campaign, "FAMILIES", FEW)
    monkeypatch.setattr(campaign, "PLACEMENTS_PER_COURSE", PER_COURSE)


def contents(out):
    return {path.name: path.read_bytes() for path in (out / "trials").iterdir()}


def assert_equal(first: Trials, second: Trials):
    for field in fields(Trials):
        np.testing.assert_array_equal(getattr(first, field.name), getattr(second, field.name))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The campaign in one go, on one core."""
    out = tmp_path_factory.mktemp("whole") / "campaign"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(campaign, "FAMILIES", FEW)
        patch.setattr(campaign, "PLACEMENTS_PER_COURSE", PER_COURSE)
        return out, run_campaign(CONFIG, out, jobs=1)


def test_every_family_is_tried_on_courses_to_fit_and_on_others(whole):
    _, trials = whole
    assert len(trials) == CONFIG.placements + CONFIG.held_out
    assert trials.slip.shape == (len(trials), len(FRICTIONS), DIRECTIONS)
    assert trials.slip.min() >= 0 and trials.slip.max() <= SLIP_CAP
    for family in (*FEW, SHAPES):
        held_out = trials.held_out[trials.family == family]
        assert (held_out.sum(), (~held_out).sum()) == (PER_COURSE, 2 * PER_COURSE)
    assert not set(trials.course[trials.held_out]) & set(trials.course[~trials.held_out])
    assert trials.uniform.mean() == 0.5


def test_feet_slip_on_rubble_and_not_on_flat_ground(whole):
    _, trials = whole
    assert trials.slip[trials.family == "flat"].max() < 1e-3
    assert trials.slip[trials.family == "rubble"].mean() > 5e-3
    assert (trials.features[1][trials.family == "flat"] == 0).all()


def test_patches_are_the_heights_around_the_cells(whole):
    """A patch alone gives the features that the cell has on its course."""
    _, trials = whole
    assert (trials.patch[:, PATCH // 2, PATCH // 2] == 0).all()
    family, seed = "rubble", 0
    of_course = np.flatnonzero((trials.family == family) & (trials.course == seed))
    course = make_course(family, seed, size=campaign.COURSE_SIZE)
    on_course = np.stack(campaign.terrain_features(course.elevation, course.resolution)[:2], axis=-1).reshape(-1, 2)
    for features in np.stack(trials.features, axis=-1)[of_course]:
        assert np.abs(on_course - features).max(axis=1).min() < 1e-5


def test_jobs_change_nothing(whole, tmp_path):
    out, trials = whole
    with joblib.parallel_config("threading"):  # Threads see the small campaign of these tests.
        assert_equal(run_campaign(CONFIG, tmp_path / "two", jobs=2), trials)
    assert contents(tmp_path / "two") == contents(out)


def test_a_killed_campaign_goes_on(whole, tmp_path):
    """Finished courses are kept, missing and torn ones tried again, and the end is the same to the byte."""
    out, trials = whole
    torn = tmp_path / "torn"
    (torn / "trials").mkdir(parents=True)
    (torn / "config.json").write_bytes((out / "config.json").read_bytes())
    parts = contents(out)
    kept, half, missing = sorted(parts)[:3]
    for name, content in parts.items():
        if name != missing:
            (torn / "trials" / name).write_bytes(content[: len(content) // 2] if name == half else content)
    before = (torn / "trials" / kept).stat().st_mtime_ns
    assert_equal(run_campaign(CONFIG, torn, jobs=1), trials)
    assert contents(torn) == parts
    assert (torn / "trials" / kept).stat().st_mtime_ns == before


def test_a_folder_belongs_to_one_configuration(whole, tmp_path):
    out, _ = whole
    with pytest.raises(InputError, match="another configuration, with seed 0 and not 1;"):
        run_campaign(replace(CONFIG, seed=1), out)
    (tmp_path / "letter.txt").write_text("mine")
    with pytest.raises(InputError, match="no campaign of slip trials"):
        run_campaign(CONFIG, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


@pytest.mark.parametrize("seed", [0, 1, 7, 1000, 123_456])
def test_courses_of_different_seeds_and_uses_differ(seed):
    """Courses to fit are never held out, whatever the seed, nor are they those of another seed."""
    config = CampaignConfig(placements=4 * 24, held_out=2 * 24, seed=seed)
    courses = np.array([course for _, course in config.jobs()])
    nothing = {field.name: courses for field in fields(Trials)}
    held_out = Trials(**nothing).held_out
    assert held_out.sum() == 2 * 4 and (~held_out).sum() == 4 * 4
    other = {course for _, course in replace(config, seed=seed + 1).jobs()}
    assert not other & set(courses.tolist())


def test_half_of_the_cells_are_drawn_evenly_and_the_others_where_it_is_rough():
    course = make_course("steps", 3, size=campaign.COURSE_SIZE)
    cells, uniform = draw_cells(course, 400, np.random.default_rng(0))
    _, k2, _ = campaign.terrain_features(course.elevation, course.resolution)
    k2 = k2[tuple(cells.T)]
    assert uniform.sum() == 200
    assert k2[~uniform].mean() > 2 * k2[uniform].mean()
    edge = campaign.MARGIN / course.resolution
    assert cells.min() >= edge - 1 and cells.max() <= len(course.elevation) - edge
