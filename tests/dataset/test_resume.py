"""Whatever stops a run, nothing half-written stays, and the same command ends with the same bytes."""

import os
import random
import resource
import signal
import time
from dataclasses import replace

import psutil
import pytest

from footsel.dataset import generate as generation
from footsel.dataset import open_dataset
from footsel.dataset.config import DatasetConfig
from footsel.dataset.folder import claimed_folder
from footsel.dataset.generate import generate
from footsel.dataset.store import shard_path
from footsel.dataset.versions import versions
from footsel.errors import InputError

#: Eighty shards of some hundredths of a second each: there is time to kill.
COMMAND = ("--maps", 400, "--maps-per-shard", 10, "--seed", 4)
CONFIG = DatasetConfig("anymal_b", ("front", "hind"), maps=400, seed=4, recipe="footsel", maps_per_shard=10)
PATIENCE = 120


@pytest.fixture(scope="module")
def unbroken(start, tmp_path_factory):
    """The folder of a run that nothing stopped, on one process, and what it said."""
    folder = tmp_path_factory.mktemp("unbroken") / "data"
    process = start(folder, *COMMAND, "--jobs", 1)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    return folder, out


def shards_in(folder):
    return len(list(folder.glob("*/shard_*.npz")))


def wait_for_shards(process, folder, count):
    """Return when the folder has this many shards, or the process is done."""
    end = time.monotonic() + PATIENCE
    while shards_in(folder) < count and process.poll() is None:
        assert time.monotonic() < end
        time.sleep(0.01)


def workers_of(process):
    children = psutil.Process(process.pid).children(recursive=True)
    return [child for child in children if "LokyProcess" in " ".join(child.cmdline())]


def test_bytes_do_not_depend_on_the_number_of_jobs(start, digests, unbroken, tmp_path):
    process = start(tmp_path / "data", *COMMAND, "--jobs", 2)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert digests(tmp_path / "data") == digests(unbroken[0])


def test_killed_again_and_again_it_ends_with_the_same_bytes(start, digests, unbroken, tmp_path):
    """SIGKILL at random moments, before the first shard and after some."""
    folder, moment = tmp_path / "data", random.Random()
    killed = said = 0
    for shards in (0, 2, 20):
        process = start(folder, *COMMAND, "--jobs", 2)
        wait_for_shards(process, folder, shards)
        time.sleep(moment.uniform(0, 0.2))
        workers = workers_of(process) if process.poll() is None else []
        process.kill()
        _, err = process.communicate(timeout=PATIENCE)
        killed += process.returncode == -signal.SIGKILL
        said += "going on with the others" in err
        # Orphans would go on for minutes, with the terminal in their hands.
        assert not psutil.wait_procs(workers, timeout=10)[1]
    assert killed == 3 and not (folder / "manifest.json").exists()
    process = start(folder, *COMMAND, "--jobs", 2)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert "going on with the others" in err and said >= 1
    assert digests(folder) == digests(unbroken[0])
    assert out.replace(str(folder), "") == unbroken[1].replace(str(unbroken[0]), "")


def test_a_killed_worker_is_one_line_and_the_rest_is_made_later(start, digests, unbroken, tmp_path):
    folder = tmp_path / "data"
    process = start(folder, *COMMAND, "--jobs", 2)
    wait_for_shards(process, folder, 1)
    workers_of(process)[0].kill()
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2 and not out
    assert err.splitlines()[-1].startswith("footsel: error: a worker process was killed")
    assert "Traceback" not in err
    generate(CONFIG, folder, jobs=1)
    assert digests(folder) == digests(unbroken[0])


def test_an_interrupt_leaves_whole_files_alone(start, tmp_path):
    """As Ctrl-C does: the signal reaches the workers too."""
    folder = tmp_path / "data"
    process = start(folder, *COMMAND, "--jobs", 2)
    # So many that both workers are at work: one that is interrupted while it starts prints Python's own traceback.
    wait_for_shards(process, folder, 4)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert err.splitlines()[-1] == "footsel: interrupted" and "Traceback" not in err
    assert not (folder / "manifest.json").exists()
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert len(files) == 1 + shards_in(folder) and not [path for path in files if path.name.startswith(".")]


def test_a_full_disk_is_one_line(start, tmp_path):
    """The system refuses to write more than 4 kB into a file."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    process = start(tmp_path / "data", "--maps", 4, "--legs", "front", "--jobs", 1, limit=limit)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2
    assert "footsel: error: cannot write" in err.splitlines()[-1] and "shard_00000.npz" in err.splitlines()[-1]
    assert "Traceback" not in err and not shards_in(tmp_path / "data")
    assert not list(tmp_path.rglob(".*"))


def test_a_folder_that_cannot_be_made_is_one_line(start, tmp_path):
    (tmp_path / "file").write_text("")
    process = start(tmp_path / "file" / "data", "--maps", 1)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2 and err.startswith("footsel: error: ") and err.count("\n") == 1


def test_missing_damaged_and_foreign_shards_are_made_again(finished, dataset, config, digests, capsys):
    complete = digests(finished)
    shard_path(dataset, "hind", 0).unlink()
    shard_path(dataset, "hind", 2).write_bytes(b"half a shard")
    # Whole, but not what the manifest describes.
    shard_path(dataset, "front", 1).write_bytes(shard_path(dataset, "front", 0).read_bytes())
    (dataset / "front" / ".shard_00001.4711.tmp.npz").write_bytes(b"left by a killed run")
    generate(config, dataset, jobs=1)
    assert digests(dataset) == complete
    said = capsys.readouterr().err
    assert said.count("is damaged and will") == 2 and "12 of 24 maps" in said


def test_a_run_that_was_killed_before_it_began_is_begun(config, tmp_path, digests, finished):
    folder = tmp_path / "data"
    folder.mkdir()
    (folder / ".config.4711.tmp.json").write_text("{")
    generate(config, folder, jobs=1)
    assert digests(folder) == digests(finished)


def test_a_finished_dataset_is_left_alone(dataset, config, monkeypatch):
    monkeypatch.setattr(generation, "_make", None)  # Nothing may be made.
    before = {path: path.stat().st_mtime_ns for path in dataset.rglob("shard_*")}
    generate(config, dataset, jobs=1)
    assert {path: path.stat().st_mtime_ns for path in dataset.rglob("shard_*")} == before


def test_an_unfinished_dataset_is_not_opened(dataset):
    (dataset / "manifest.json").unlink()
    with pytest.raises(InputError, match="no finished dataset"):
        open_dataset(dataset)


def test_another_configuration_is_refused_and_named(dataset, config):
    with pytest.raises(InputError, match=r"holds a finished dataset .* with config\.seed 3 and not 4;"):
        generate(replace(config, seed=4), dataset, jobs=1)


def test_other_software_does_not_go_on(dataset, config):
    with (
        pytest.raises(InputError, match=r"versions\.numpy 2.*and not 1\.0"),
        claimed_folder(dataset, config, {**versions(), "numpy": "1.0"}),
    ):
        pass


def test_two_processes_do_not_write_into_one_folder(dataset, config):
    with (
        claimed_folder(dataset, config, versions()),
        pytest.raises(InputError, match="another process"),
        claimed_folder(dataset, config, versions()),
    ):
        pass
    generate(config, dataset, jobs=1)  # The first one is done.


def test_a_folder_with_other_things_is_refused(tmp_path, config):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="not empty"):
        generate(config, tmp_path, jobs=1)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_a_worker_with_other_software_is_refused(config, tmp_path, monkeypatch):
    """What a worker says of itself is compared with what the manifest would say."""
    make = generation._make_shard

    def make_elsewhere(*key):
        return replace(make(*key), versions={**versions(), "coal": "0.1"})

    monkeypatch.setattr(generation, "_make_shard", make_elsewhere)
    with pytest.raises(InputError, match=r"a worker has coal 0\.1 and not"):
        generate(config, tmp_path / "data", jobs=1)
    assert not shards_in(tmp_path / "data")
