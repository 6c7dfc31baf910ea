"""The same dataset from a Dask cluster: a scheduler and two workers, real processes on the loopback interface."""

import os
import signal
import subprocess
import sys
import time

import pytest

from footsel.dataset import engine
from footsel.dataset.config import DatasetConfig
from footsel.dataset.generate import generate
from footsel.errors import InputError

distributed = pytest.importorskip("distributed")

COMMAND = ("--maps", 40, "--maps-per-shard", 10, "--seed", 4, "--engine", "dask", "--scheduler")
PATIENCE = 120


class Cluster:
    """A Dask scheduler, and its workers."""

    def __init__(self, folder):
        self._folder = folder
        self._processes = []
        file = folder / "scheduler.json"
        self.scheduler = self._start("scheduler", "--no-dashboard", "--port", "0", "--scheduler-file", file)
        end = time.monotonic() + PATIENCE
        while not file.exists() or not file.stat().st_size:
            assert time.monotonic() < end and self.scheduler.poll() is None
            time.sleep(0.05)
        with distributed.Client(scheduler_file=str(file), timeout=PATIENCE, set_as_default=False) as client:
            self.address = client.scheduler.address

    def add_worker(self):
        """A worker of two threads, in a folder of its own as on another machine."""
        return self._start("worker", self.address, "--nthreads", "2", "--no-nanny", "--no-dashboard")

    def stop(self):
        for process in self._processes:
            process.kill()
            process.wait()

    def _start(self, role, *arguments):
        folder = self._folder / f"{role}{len(self._processes)}"
        folder.mkdir()
        process = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_" + role, "--host", "127.0.0.1", *map(str, arguments)],
            cwd=folder,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
        self._processes.append(process)
        return process


@pytest.fixture
def cluster(tmp_path):
    cluster = Cluster(tmp_path)
    yield cluster
    cluster.stop()


def test_a_dask_cluster_gives_the_same_bytes(cluster, start, digests, tmp_path):
    """One of its workers is killed on the way: the other one does its work."""
    workers = [cluster.add_worker(), cluster.add_worker()]
    process = start(tmp_path / "dask", *COMMAND, cluster.address)
    while not list(tmp_path.glob("dask/*/shard_*")) and process.poll() is None:
        time.sleep(0.01)
    workers[0].kill()
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert out.startswith("front: 40 maps")
    config = DatasetConfig("anymal_b", ("front", "hind"), 40, 4, "footsel", maps_per_shard=10)
    generate(config, tmp_path / "here", jobs=1)
    assert digests(tmp_path / "dask") == digests(tmp_path / "here")


@pytest.mark.slow  # What a dying cluster reports first depends on how busy the machine is.
def test_a_scheduler_that_dies_is_one_line(cluster, start, tmp_path):
    cluster.add_worker()
    process = start(tmp_path / "dask", "--maps", 4000, "--maps-per-shard", 5, *COMMAND[4:], cluster.address)
    while not list(tmp_path.glob("dask/*/shard_*")) and process.poll() is None:
        time.sleep(0.01)
    cluster.scheduler.send_signal(signal.SIGKILL)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2
    assert err.splitlines()[-1].startswith(f"footsel: error: the Dask cluster at {cluster.address} lost the work")
    assert "Traceback" not in err, err
    assert not list(tmp_path.glob("dask/**/.*"))


def test_a_scheduler_without_workers_is_one_line(cluster, tmp_path, monkeypatch, config):
    monkeypatch.setattr(engine, "PATIENCE", 1)
    with pytest.raises(InputError, match="has no workers"):
        generate(config, tmp_path / "dask", scheduler=cluster.address)
    assert not (tmp_path / "dask").exists()


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", "tcp://127.0.0.1:port", "post://127.0.0.1:1"])
def test_a_wrong_address_is_one_line(tmp_path, address, monkeypatch, config):
    monkeypatch.setattr(engine, "PATIENCE", 1)
    with pytest.raises(InputError, match="no Dask scheduler answers at"):
        generate(config, tmp_path / "dask", scheduler=address)
    assert not (tmp_path / "dask").exists()


def test_the_command_names_a_wrong_address_in_one_line(start, tmp_path):
    process = start(tmp_path / "dask", *COMMAND, "nonsense")
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 2 and not out
    assert err.startswith("footsel: error: no Dask scheduler answers at nonsense") and err.count("\n") == 1
