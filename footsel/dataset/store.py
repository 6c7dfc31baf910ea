"""A dataset on disk: a folder per pair with `.npz` shards, and a manifest that describes and seals them."""

import hashlib
import io
import json
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from footsel.dataset.samples import Samples
from footsel.dataset.sampling import COMPOSED
from footsel.dataset.tally import Tally, add_tallies, tally_of, tally_shares
from footsel.errors import InputError, UnknownNameError
from footsel.files import replace_file, writing
from footsel.legs import check_pair
from footsel.terrain.courses import FAMILIES

MANIFEST = "manifest.json"

#: Share of the shards, the last ones, that training holds back.
VALIDATION_SHARE = 0.05


@dataclass(frozen=True, eq=False)
class Dataset:
    """A finished dataset.

    path: its folder. manifest: what `manifest.json` says. sha256: of that file, which holds the hash of every shard.
    """

    path: Path
    manifest: dict[str, Any]
    sha256: str

    @property
    def pairs(self) -> tuple[str, ...]:
        """The leg pairs that it has shards for."""
        return tuple(self.manifest["pairs"])

    def shard_count(self, pair: str) -> int:
        """Number of shards of a pair."""
        return len(self._entry(pair)["shards"])

    def load(
        self,
        pair: str,
        shards: Iterable[int] | None = None,
        families: Sequence[str] | None = None,
        exclude: Sequence[str] | None = None,
    ) -> Samples:
        """Samples of a pair: of the given shards and terrain families (default all), without the excluded families.

        Raises InputError for a pair that it has not, or a family that nobody knows.
        """
        self._check_families(pair, (*(families or ()), *(exclude or ())))
        numbers = range(self.shard_count(pair)) if shards is None else shards
        samples = Samples.concatenate([read_shard(shard_path(self.path, pair, number)) for number in numbers])
        keep = np.ones(len(samples), dtype=np.bool_)
        if families:
            keep &= np.isin(samples.family, families)
        if exclude:
            keep &= ~np.isin(samples.family, exclude)
        return samples if keep.all() else samples.take(keep)

    def split(
        self, pair: str, families: Sequence[str] | None = None, exclude: Sequence[str] | None = None
    ) -> tuple[Samples, Samples]:
        """(training, validation) samples of the given families; validation is the last 5 % of the shards, at least one.

        They share no course. The exception is the paper's recipe, which samples both from its one map.
        """
        count = self.shard_count(pair)
        held = max(int(count * VALIDATION_SHARE), 1)
        if held >= count:
            raise InputError(
                f"the dataset {self.path} has {count} shard of {pair}", "training needs at least two: make more maps"
            )
        training = self.load(pair, range(count - held), families, exclude)
        validation = self.load(pair, range(count - held, count), families, exclude)
        # Shards draw their courses' seeds apart from each other, so the same one may come twice in a billion.
        shared = np.isin(validation.course, training.course) & (validation.family != COMPOSED)
        return training, validation.take(~shared)

    def verify(self) -> None:
        """Raise InputError if a shard is not the one that the manifest describes."""
        for pair in self.pairs:
            for number, entry in enumerate(self._entry(pair)["shards"]):
                path = shard_path(self.path, pair, number)
                if not path.exists() or _sha256(path) != entry["sha256"]:
                    raise InputError(f"{path} is missing or differs from the manifest", "generate the dataset again")

    def _check_families(self, pair: str, names: Sequence[str]) -> None:
        known = self._entry(pair)["families"]
        for name in names:
            if name not in (*known, *FAMILIES):
                raise UnknownNameError("terrain family", name, known)

    def _entry(self, pair: str) -> dict[str, Any]:
        if check_pair(pair) not in self.manifest["pairs"]:
            raise InputError(f"the dataset {self.path} has no {pair} legs", f"it has: {', '.join(self.pairs)}")
        entry: dict[str, Any] = self.manifest["pairs"][pair]
        return entry


def open_dataset(path: str | Path) -> Dataset:
    """Read the manifest of a dataset folder; raises InputError if there is none or it is damaged."""
    file = Path(path) / MANIFEST
    if not file.exists():
        raise InputError(f"{path} holds no finished dataset", "make one, or finish it, with `footsel dataset`")
    try:
        manifest = json.loads(file.read_text(encoding="utf-8"))
        manifest["pairs"], manifest["config"]["robot"]
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{file} is damaged", "run the same `footsel dataset` command again") from None
    return Dataset(Path(path), manifest, _sha256(file))


def shard_path(root: Path, pair: str, number: int) -> Path:
    """File of one shard."""
    return root / pair / f"shard_{number:05d}.npz"


def pack_shard(samples: Samples) -> bytes:
    """The content of a shard's file: the same bytes for the same samples."""
    file = io.BytesIO()
    # The zip's time stamps are constants of NumPy's writer.
    np.savez_compressed(file, **{f.name: getattr(samples, f.name) for f in fields(samples)})
    return file.getvalue()


def write_shard(path: Path, content: bytes) -> None:
    """Write what pack_shard made; the file appears whole or not at all."""
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, lambda temporary: temporary.write_bytes(content))


def read_shard(path: Path) -> Samples:
    """Read a shard; raises InputError if it is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return Samples(**{f.name: stored[f.name] for f in fields(Samples)})
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(
            f"cannot read the shard {path} ({error})", "delete it and run `footsel dataset` again"
        ) from None


@dataclass(frozen=True, eq=False)
class ShardRecord:
    """What the manifest needs to know of a shard."""

    file: str
    samples: int
    sha256: str
    tally: Tally


def record_shard(root: Path, pair: str, number: int) -> ShardRecord:
    """Read a shard and describe it; raises InputError if it is missing or damaged."""
    path = shard_path(root, pair, number)
    samples = read_shard(path)
    return ShardRecord(path.relative_to(root).as_posix(), len(samples), _sha256(path), tally_of(samples))


def pair_entry(records: Sequence[ShardRecord]) -> dict[str, Any]:
    """The manifest's entry of a pair: its shards with their hashes, and the shares of what they hold."""
    shards = [{"file": record.file, "samples": record.samples, "sha256": record.sha256} for record in records]
    return {"shards": shards, **tally_shares(add_tallies(record.tally for record in records))}


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
