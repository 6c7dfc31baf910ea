"""Many walks: real ones, of the first second and a half, whose results depend on nothing but their jobs."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from footsel.errors import InputError, ModelError, UnknownNameError
from footsel.walking.runs.campaign import walk_all
from footsel.walking.runs.job import WalkJob
from footsel.walking.runs.kept import RUNS, kept

JOBS = [
    WalkJob(terrain, selector, seed, time_limit_s=1.5)
    for terrain in ("flat", "stones")
    for selector in ("nominal", "terrain_only")
    for seed in (0, 1)
]


def untimed(walks):
    return [({**result.to_dict(), "realtime_factor": 0}, trace) for result, trace in walks]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The folder of all walks by one process, and what came of them."""
    folder = tmp_path_factory.mktemp("walks") / "out"
    return folder, walk_all(JOBS, folder, jobs=1)


def test_each_walk_is_of_its_job(done):
    folder, walks = done
    assert [(r.terrain, r.selector, r.seed, r.map) for r, _ in walks] == [
        (job.terrain, job.selector, job.seed, "exact") for job in JOBS
    ]
    for result, trace in walks:
        assert result.duration_s == pytest.approx(1.5, abs=0.1)
        assert not result.success and result.reason
        assert len(trace.base) == 3 and trace.footholds
    assert len(list((folder / RUNS).iterdir())) == len(JOBS)


def test_selectors_and_seeds_make_a_difference(done):
    _, walks = done
    traces = {(job.terrain, job.selector, job.seed): trace for job, (_, trace) in zip(JOBS, walks, strict=True)}
    assert traces["flat", "nominal", 0] != traces["flat", "nominal", 1]
    assert traces["stones", "nominal", 0].footholds != traces["stones", "terrain_only", 0].footholds


def test_results_do_not_depend_on_the_number_of_jobs(done, tmp_path):
    assert untimed(walk_all(JOBS, tmp_path / "out", jobs=2)) == untimed(done[1])


def test_finished_walks_are_not_repeated(done, capsys):
    folder, walks = done
    before = {path.name: path.stat().st_mtime_ns for path in (folder / RUNS).iterdir()}
    assert walk_all(JOBS, folder, jobs=1) == walks
    assert {path.name: path.stat().st_mtime_ns for path in (folder / RUNS).iterdir()} == before
    assert f"has {len(JOBS)} of {len(JOBS)} walks" in capsys.readouterr().err


def test_what_is_missing_or_damaged_is_walked_again(done):
    folder, walks = done
    (folder / RUNS / JOBS[1].file_name).unlink()
    damaged = folder / RUNS / JOBS[2].file_name
    damaged.write_text(damaged.read_text()[:100])
    again = walk_all(JOBS, folder, jobs=1)
    assert untimed(again) == untimed(walks)
    assert [a == b for a, b in zip(again, walks, strict=True)].count(False) <= 2
    assert kept(folder, JOBS[1]) is not None and kept(folder, JOBS[2]) is not None


def test_more_walks_may_be_asked_for(done):
    folder, walks = done
    more = [*JOBS[:2], replace(JOBS[0], seed=5)]
    assert untimed(walk_all(more, folder, jobs=1)[:2]) == untimed(walks[:2])


def test_another_question_is_refused(done, tmp_path):
    folder, _ = done
    with pytest.raises(InputError, match=r"another configuration, with map exact and not noisy"):
        walk_all([replace(JOBS[0], map="noisy")], folder)
    with pytest.raises(InputError, match="time limit s"):
        walk_all([replace(JOBS[0], time_limit_s=2.0)], folder)
    (tmp_path / "letter").touch()
    with pytest.raises(InputError, match="is not empty"):
        walk_all(JOBS, tmp_path)
    with pytest.raises(InputError, match="no walk"):
        walk_all([], tmp_path)


def test_a_map_that_changed_under_its_name_is_noticed(tmp_path):
    path = tmp_path / "field.npz"
    np.savez(path, elevation=np.zeros((60, 60)), resolution=0.02)
    job = WalkJob(str(path), "nominal", 0, time_limit_s=0.1)
    walk_all([job], tmp_path / "out", jobs=1)
    np.savez(path, elevation=np.full((60, 60), 0.1), resolution=0.02)
    with pytest.raises(InputError, match="another map file"):
        walk_all([job], tmp_path / "out", jobs=1)


def test_names_are_checked_and_files_told_apart():
    with pytest.raises(UnknownNameError, match="selector 'guess'"):
        WalkJob("flat", "guess", 0)
    with pytest.raises(UnknownNameError, match="map 'radar'"):
        WalkJob("flat", "cnn", 0, map="radar")
    with pytest.raises(ModelError, match="nowhere"):
        WalkJob("flat", "cnn", 0, model="nowhere").question()
    names = {WalkJob(terrain, "cnn", 0).file_name for terrain in ("a/m.npz", "b/m.npz", "flat")}
    assert len(names) == 3


SCRIPT = """
from pathlib import Path
from footsel.walking.runs.campaign import walk_all
from footsel.walking.runs.job import WalkJob
if __name__ == "__main__":
    walk_all([WalkJob("flat", "nominal", seed, time_limit_s=1.5) for seed in range(6)], Path("out"), jobs=1)
"""


def test_killed_it_goes_on_where_it_stopped(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    command = [sys.executable, "script.py"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, env=os.environ)
    end = time.monotonic() + 120
    while len(list(tmp_path.glob("out/runs/*.json"))) < 2 and process.poll() is None:
        assert time.monotonic() < end
        time.sleep(0.02)
    process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    first = {path.name: path.read_bytes() for path in tmp_path.glob("out/runs/[!.]*.json")}
    assert 2 <= len(first) < 6
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=240)
    assert done.returncode == 0, done.stderr
    assert "going on with the others" in done.stderr
    files = {path.name: path.read_bytes() for path in tmp_path.glob("out/runs/*.json")}
    assert len(files) == 6 and all(files[name] == content for name, content in first.items())
    assert json.loads(files["flat_nominal_0.json"])["result"]["terrain"] == "flat"


def test_the_same_walks_on_a_dask_cluster(done, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=True, dashboard_address=None) as cluster:
        walks = walk_all(JOBS[:3], tmp_path / "out", scheduler=cluster.scheduler_address)
    assert untimed(walks) == untimed(done[1][:3])
