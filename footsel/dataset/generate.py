"""Labelled pairs in parallel. A shard's bytes depend on the seed, the pair and the shard's number alone.

The workers hand the content of shards back and this process alone writes: a file is there whole or not at all, whatever
is killed, and a cluster needs no common disk.
"""

import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import joblib
from tqdm import tqdm

from footsel.dataset.config import DatasetConfig
from footsel.dataset.engine import engine
from footsel.dataset.folder import claimed_folder
from footsel.dataset.store import (
    MANIFEST,
    ShardRecord,
    open_dataset,
    pack_shard,
    pair_entry,
    record_shard,
    shard_path,
    write_shard,
)
from footsel.dataset.tally import add_tallies, tally_shares
from footsel.dataset.versions import versions
from footsel.errors import InputError
from footsel.files import write_json

#: Pair of legs and number of a shard.
ShardKey = tuple[str, int]


@dataclass(frozen=True)
class MadeShard:
    """What a worker hands back: the content of a shard's file, and the versions of the software that made it."""

    pair: str
    number: int
    content: bytes
    versions: dict[str, str]


def generate(config: DatasetConfig, out: Path, jobs: int = -1, scheduler: str | None = None) -> Path:
    """Make or finish the dataset in folder `out`; shards that are already there are kept. Returns the manifest's path.

    jobs: processes on this machine, -1 for one per core. scheduler: address of a Dask scheduler whose workers do the
    work in their place.
    Raises InputError if the folder holds something else, WorkersLostError if workers die.
    """
    with engine(scheduler) as place, claimed_folder(out, config, versions()):
        records = _finished(config, out)
        missing = [key for key in config.shard_keys() if key not in records]
        if missing:
            (out / MANIFEST).unlink(missing_ok=True)
            _make(config, out, missing, records, jobs, place)
        write_json(out / MANIFEST, _manifest(config, records))
    return out / MANIFEST


def _finished(config: DatasetConfig, out: Path) -> dict[ShardKey, ShardRecord]:
    """Shards of an earlier run; one that is damaged, or not the one that a manifest describes, is made again."""
    sealed = _sealed(out)
    records = {}
    for key in config.shard_keys():
        path = shard_path(out, *key)
        if not path.exists():
            continue
        try:
            record = record_shard(out, *key)
        except InputError:
            record = None
        if record is None or sealed.get(record.file, record.sha256) != record.sha256:
            print(f"{path} is damaged and will be made again", file=sys.stderr)
        else:
            records[key] = record
    return records


def _sealed(out: Path) -> dict[str, str]:
    """sha256 of every shard's file, if an earlier run came to its end."""
    try:
        pairs = open_dataset(out).manifest["pairs"]
        return {shard["file"]: shard["sha256"] for entry in pairs.values() for shard in entry["shards"]}
    except (InputError, AttributeError, KeyError, TypeError):
        return {}


def _make(
    config: DatasetConfig,
    out: Path,
    missing: list[ShardKey],
    records: dict[ShardKey, ShardRecord],
    jobs: int,
    place: str,
) -> None:
    """Make the missing shards, write each as it comes in, and add its record."""
    done = sum(record.samples for record in records.values())
    total = config.maps * len(config.pairs)
    if done:
        print(f"{out} has {done} of {total} maps; going on with the others {place}", file=sys.stderr)
    with tqdm(
        total=total,
        initial=done,
        desc="maps",
        unit=" maps",
        smoothing=0.1,
        # Into a file go a few lines and not a picture that moves.
        mininterval=0.2 if sys.stderr.isatty() else 15,
    ) as progress:
        for made in _work(config, missing, jobs):
            _check_versions(made.versions)
            key = made.pair, made.number
            write_shard(shard_path(out, *key), made.content)
            records[key] = record_shard(out, *key)
            progress.update(records[key].samples)


def _work(config: DatasetConfig, missing: list[ShardKey], jobs: int) -> Iterator[MadeShard]:
    """The missing shards, in the order in which they get ready."""
    with joblib.Parallel(n_jobs=jobs, return_as="generator_unordered") as parallel:
        # Tables that do not exist yet are built once per pair and not by every worker.
        for _ in parallel(joblib.delayed(_prepare)(config, pair) for pair in dict(missing)):
            pass
        yield from parallel(joblib.delayed(_make_shard)(config, pair, number) for pair, number in missing)


def _prepare(config: DatasetConfig, pair: str) -> None:
    # Robot models and numba are for the workers: the process that asks them stays small.
    from footsel.dataset.labelling import prepare

    prepare(config, pair)


def _make_shard(config: DatasetConfig, pair: str, number: int) -> MadeShard:
    from footsel.dataset.labelling import make_samples

    return MadeShard(pair, number, pack_shard(make_samples(config, pair, number)), versions())


def _check_versions(found: dict[str, str]) -> None:
    """Raise InputError if a worker's software is not ours, which the manifest will name."""
    others = [
        f"{name} {found.get(name)} and not {ours}" for name, ours in versions().items() if found.get(name) != ours
    ]
    if others:
        raise InputError(f"a worker has {', '.join(others)}", "install the same on all machines")


def _manifest(config: DatasetConfig, records: dict[ShardKey, ShardRecord]) -> dict[str, Any]:
    """Everything about the dataset, in an order that does not depend on who finished first."""
    ordered = {pair: [records[pair, number] for number in range(config.shards)] for pair in config.pairs}
    return {
        "config": asdict(config),
        "versions": versions(),
        **tally_shares(add_tallies(record.tally for record in records.values())),
        "pairs": {pair: pair_entry(ordered[pair]) for pair in config.pairs},
    }
