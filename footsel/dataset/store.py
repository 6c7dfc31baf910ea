"""A dataset on disk: a folder per pair with `.npz` shards, and a manifest that describes and seals them."""

import hashlib
import json
import zipfile
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footsel.dataset.samples import Samples
from footsel.errors import InputError
from footsel.files import replace_file
from footsel.footholds.cost import CLASSES, cost_to_class
from footsel.footholds.reasons import REASON_NAMES, Reason
from footsel.legs import check_pair

MANIFEST = "manifest.json"

#: Share of the shards, the last ones, that training holds back. Shards share no course, so nothing leaks.
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
        """Samples of a pair: of the given shards (default all) and terrain families."""
        numbers = range(self.shard_count(pair)) if shards is None else shards
        samples = Samples.concatenate([read_shard(shard_path(self.path, pair, number)) for number in numbers])
        keep = np.ones(len(samples), dtype=np.bool_)
        if families:
            keep &= np.isin(samples.family, families)
        if exclude:
            keep &= ~np.isin(samples.family, exclude)
        return samples if keep.all() else samples.take(keep)

    def split(self, pair: str) -> tuple[Samples, Samples]:
        """(training, validation) samples; validation is the last 5 % of the shards, at least one."""
        count = self.shard_count(pair)
        held = max(int(count * VALIDATION_SHARE), 1)
        if held >= count:
            raise InputError(f"the dataset {self.path} has {count} shard of {pair}", "training needs at least two")
        return self.load(pair, range(count - held)), self.load(pair, range(count - held, count))

    def verify(self) -> None:
        """Raise InputError if a shard is not the one that the manifest describes."""
        for pair in self.pairs:
            for number, entry in enumerate(self._entry(pair)["shards"]):
                path = shard_path(self.path, pair, number)
                if not path.exists() or _sha256(path) != entry["sha256"]:
                    raise InputError(f"{path} is missing or differs from the manifest", "generate the dataset again")

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


def write_shard(path: Path, samples: Samples) -> None:
    """Write a shard; it appears whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    arrays = {f.name: getattr(samples, f.name) for f in fields(samples)}
    replace_file(path, lambda temporary: np.savez_compressed(temporary, **arrays))


def read_shard(path: Path) -> Samples:
    """Read a shard; raises InputError if it is missing or damaged."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return Samples(**{f.name: stored[f.name] for f in fields(Samples)})
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(
            f"cannot read the shard {path} ({error})", "delete it and run `footsel dataset` again"
        ) from None


def summarise(root: Path, pair: str, shards: int) -> dict[str, Any]:
    """The manifest's entry of a pair: shards with their hashes, class shares, reason shares overall and per family.

    Shards are read one at a time, so memory does not grow with their number.
    """
    entries = []
    classes = np.zeros(CLASSES, dtype=np.int64)
    samples: Counter[str] = Counter()
    reasons: defaultdict[str, NDArray[np.int64]] = defaultdict(lambda: np.zeros(len(REASON_NAMES), dtype=np.int64))
    for number in range(shards):
        path = shard_path(root, pair, number)
        shard = read_shard(path)
        entries.append({"file": f"{pair}/{path.name}", "samples": len(shard), "sha256": _sha256(path)})
        classes += np.bincount(cost_to_class(shard.cost).ravel(), minlength=CLASSES)
        for family in np.unique(shard.family).tolist():
            of_family = shard.family == family
            samples[family] += int(of_family.sum())
            reasons[family] += np.bincount(shard.reason[of_family].ravel(), minlength=len(REASON_NAMES))
    return {
        "samples": samples.total(),
        "shards": entries,
        "class_shares": (classes / classes.sum()).tolist(),
        "reason_shares": _reason_shares(np.sum(list(reasons.values()), axis=0)),
        "families": {
            family: {"samples": samples[family], "reason_shares": _reason_shares(reasons[family])}
            for family in sorted(samples)
        },
    }


def write_json(path: Path, values: Any) -> None:
    """Write JSON; the file appears whole or not at all."""
    text = json.dumps(values, indent=1) + "\n"
    replace_file(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def _reason_shares(counts: NDArray[np.int64]) -> dict[str, float]:
    """Share of each reason; UNKNOWN of all cells, the others of the known ones."""
    total = max(int(counts.sum()), 1)
    known = max(total - int(counts[Reason.UNKNOWN]), 1)
    return {reason.name: float(counts[reason] / (total if reason is Reason.UNKNOWN else known)) for reason in Reason}


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
