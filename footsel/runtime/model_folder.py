"""A released model folder: two networks, their papers, and the checksums that hold them together."""

import hashlib
from collections.abc import Mapping
from pathlib import Path

from footsel.errors import ModelError
from footsel.legs import PAIRS
from footsel.runtime.contract import ModelContract
from footsel.runtime.network import Network

SUMS_FILE = "SHA256SUMS"
PARITY_FILE = "parity.json"
#: Variant -> end of its file name. "float32" is what was trained; "int8" is quantised.
VARIANTS = {"float32": ".onnx", "int8": ".int8.onnx"}
DEFAULT_VARIANT = "float32"

#: Package data of an installed footsel, then the folder that a checkout releases from.
MODEL_ROOTS = (Path(__file__).resolve().parents[1] / "models", Path(__file__).resolve().parents[2] / "export")


def network_file(pair: str, variant: str = DEFAULT_VARIANT) -> str:
    """Name of a pair's network in a model folder, such as `front.onnx`."""
    if variant not in VARIANTS:
        raise ModelError(f"unknown model variant {variant!r}", f"choose from: {', '.join(VARIANTS)}")
    return pair + VARIANTS[variant]


def available_models() -> tuple[str, ...]:
    """Names that `find_model_folder` resolves without a path."""
    return tuple(sorted({sums.parent.name for root in MODEL_ROOTS for sums in root.glob(f"*/{SUMS_FILE}")}))


def find_model_folder(model: str | Path) -> Path:
    """Folder of a released model's name, or of a path; raises ModelError that lists the names there are."""
    if str(model) in available_models():
        return next(root / str(model) for root in MODEL_ROOTS if (root / str(model) / SUMS_FILE).is_file())
    path = Path(model)
    if path.is_dir():
        return path
    if path.is_file():
        raise ModelError(f"{path} is a file", f"give the model folder that holds it: {path.parent}")
    known = ", ".join(available_models()) or "none here"
    raise ModelError(
        f"no model {str(model)!r}", f"give the path of a model folder or a released model (available: {known})"
    )


def available_variants(folder: Path) -> tuple[str, ...]:
    """Variants that a model folder lists; raises ModelError if it is no model folder."""
    sums = _read_sums(folder)
    return tuple(v for v in VARIANTS if all(network_file(pair, v) in sums for pair in PAIRS))


def load_networks(folder: Path, variant: str = DEFAULT_VARIANT) -> dict[str, Network]:
    """The front and hind network of a folder, after every file of it was checked.

    Raises ModelError for a missing or changed file, for front and hind swapped, and for two robots in one folder.
    """
    names = {pair: network_file(pair, variant) for pair in PAIRS}
    contents = read_checked(folder, keep=tuple(names.values()))
    networks = {pair: Network.from_bytes(contents[name], str(folder / name)) for pair, name in names.items()}
    _check_pairing(folder, {pair: network.contract for pair, network in networks.items()})
    return networks


def checksum(content: bytes) -> str:
    """SHA-256 in hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def sums_text(contents: Mapping[str, bytes]) -> str:
    """SHA256SUMS of files by name, in the form that `sha256sum -c` reads."""
    return "".join(f"{checksum(content)}  {name}\n" for name, content in sorted(contents.items()))


def _read_sums(folder: Path) -> dict[str, str]:
    """File name -> SHA-256, from a folder's SHA256SUMS."""
    path = folder / SUMS_FILE
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except FileNotFoundError:
        raise ModelError(f"{folder} has no {SUMS_FILE}", "give a folder written by `footsel export`") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(f"cannot read {path} ({error})", "copy or export the model again") from None
    sums = {}
    for line in filter(None, lines):
        digest, _, name = line.partition("  ")
        # A name is that of a file in this folder: no path may lead out of it.
        if len(digest) != 64 or not name or Path(name).name != name:
            raise ModelError(f"{path} has a damaged line {line!r}", "copy or export the model again")
        sums[name] = digest
    return sums


def read_checked(folder: Path, keep: tuple[str, ...]) -> dict[str, bytes]:
    """Contents of the files `keep`, read once, after every file of the folder matched its checksum."""
    sums = _read_sums(folder)
    for name in keep:
        if name not in sums:
            offered = ", ".join(available_variants(folder)) or "none"
            remedy = f"variants of this model: {offered}" if name.endswith(".onnx") else "give one exported with it"
            raise ModelError(f"{folder / SUMS_FILE} does not list {name}", remedy)
    contents = {}
    for name, digest in sums.items():
        try:
            content = (folder / name).read_bytes()
        except OSError as error:
            raise ModelError(
                f"cannot read {folder / name} ({error.strerror})", "copy or export the whole model folder again"
            ) from None
        if checksum(content) != digest:
            raise ModelError(
                f"{folder / name} is not the file that was released (its SHA-256 differs from {SUMS_FILE})",
                "copy or export the whole model folder again",
            )
        if name in keep:
            contents[name] = content
    return contents


def _check_pairing(folder: Path, contracts: dict[str, ModelContract]) -> None:
    """Refuse networks of the wrong pair, or of two robots."""
    for pair, contract in contracts.items():
        if contract.pair != pair:
            raise ModelError(
                f"the {pair} network of {folder} was trained for the {contract.pair} legs",
                "put front and hind files back under their names",
            )
    front, hind = contracts["front"], contracts["hind"]
    if front.robot != hind.robot:
        raise ModelError(
            f"{folder} mixes robots: front is {front.robot!r}, hind is {hind.robot!r}", "export both for one robot"
        )
    if front.layout.to_dict() != hind.layout.to_dict() or front.distance_weight != hind.distance_weight:
        raise ModelError(f"{folder} mixes two layouts of {front.robot!r}", "export both networks in one run")
