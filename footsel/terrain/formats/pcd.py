"""The PCD format of the Point Cloud Library, version 0.7: ascii, binary and binary_compressed.

Format: https://pointclouds.org/documentation/tutorials/pcd_file_format.html
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footsel.errors import MapError


@dataclass(frozen=True)
class _Header:
    names: list[str]
    formats: list[str]
    counts: list[int]
    points: int
    encoding: str

    def dtype(self) -> np.dtype[np.void]:
        """One point as it lies in memory."""
        fields = enumerate(zip(self.formats, self.counts, strict=True))
        return np.dtype([(self.key(number), form, (count,)) for number, (form, count) in fields])

    def key(self, number: int) -> str:
        """Name of a field in `dtype`; padding fields all share the name `_`, so each is told apart by its number."""
        return f"{number}_{self.names[number]}"

    def xyz(self) -> list[int]:
        """Numbers of the fields x, y and z."""
        return [self.names.index(axis) for axis in "xyz"]


def read_points(path: Path) -> NDArray[np.float64]:
    """(n, 3) x, y, z of a PCD file; raises MapError, or ValueError and its kin for damage."""
    content = path.read_bytes()
    header, data = _read_header(content)
    if header.encoding == "ascii":
        values = np.array(data.split(), dtype=np.float64).reshape(header.points, sum(header.counts))
        columns = np.cumsum([0, *header.counts])
        return values[:, columns[header.xyz()]]
    if header.encoding == "binary":
        points = np.frombuffer(data, header.dtype(), header.points)
        return np.concatenate([points[header.key(k)] for k in header.xyz()], axis=1).astype(np.float64)
    if header.encoding == "binary_compressed":
        packed, unpacked = (int(size) for size in np.frombuffer(data, "<u4", 2))
        return _fields_apart(decompress_lzf(data[8 : 8 + packed], unpacked), header)
    raise MapError(f"has DATA {header.encoding}", "expected ascii, binary or binary_compressed")


def _read_header(content: bytes) -> tuple[_Header, bytes]:
    entries: dict[str, list[str]] = {}
    start = 0
    while "DATA" not in entries:
        end = content.find(b"\n", start)
        if end < 0:
            raise MapError("has no PCD header", "the file is damaged or of another format")
        words = content[start:end].decode("ascii").split()
        start = end + 1
        if words and not words[0].startswith("#"):
            entries[words[0]] = words[1:]
    names = entries["FIELDS"]
    if not {"x", "y", "z"} <= set(names):
        raise MapError(f"has fields {', '.join(names)}", "expected x, y and z")
    kinds = {"F": "f", "I": "i", "U": "u"}
    formats = [f"<{kinds[kind]}{size}" for kind, size in zip(entries["TYPE"], entries["SIZE"], strict=True)]
    counts = [int(count) for count in entries.get("COUNT", ["1"] * len(names))]
    points = int(entries["POINTS"][0]) if "POINTS" in entries else int(entries["WIDTH"][0]) * int(entries["HEIGHT"][0])
    if points < 0 or any(counts[names.index(axis)] != 1 for axis in "xyz"):
        raise MapError(f"has {points} points and fields of counts {counts}", "expected one x, y and z for each point")
    return _Header(names, formats, counts, points, entries["DATA"][0]), content[start:]


def _fields_apart(data: bytes, header: _Header) -> NDArray[np.float64]:
    """(n, 3) x, y, z where all values of one field lie together, before those of the next."""
    sizes = [
        np.dtype(form).itemsize * count * header.points
        for form, count in zip(header.formats, header.counts, strict=True)
    ]
    starts = np.cumsum([0, *sizes])
    columns = [np.frombuffer(data, header.formats[k], header.points, starts[k]) for k in header.xyz()]
    return np.stack(columns, axis=-1).astype(np.float64)


def decompress_lzf(packed: bytes, size: int) -> bytes:
    """Unpack LZF (liblzf): runs of literal bytes, and copies of what was unpacked before; `size` bytes come out."""
    unpacked = bytearray()
    at = 0
    while at < len(packed):
        control = packed[at]
        at += 1
        if control < 32:  # A run of control + 1 literal bytes.
            unpacked += packed[at : at + control + 1]
            at += control + 1
            continue
        length = control >> 5  # A copy of length + 2 bytes; a length of 7 goes on in the next byte.
        if length == 7:
            length += packed[at]
            at += 1
        length += 2
        distance = ((control & 31) << 8 | packed[at]) + 1
        at += 1
        if distance > len(unpacked):
            raise ValueError("compressed data refers to bytes before its start")
        start = len(unpacked) - distance
        source = unpacked[start : start + length]
        # A copy may overlap what it writes: its source then repeats.
        unpacked += (source * (length // len(source) + 1))[:length]
    if len(unpacked) != size:
        raise ValueError(f"compressed data gives {len(unpacked)} bytes, the header says {size}")
    return bytes(unpacked)
