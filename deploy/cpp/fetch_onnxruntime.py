#!/usr/bin/env python3
"""Lay out onnxruntime for C++ as its release tarballs do, ROOT/include and ROOT/lib, from two package registries.

    python fetch_onnxruntime.py ROOT

The library is that of the installed Python wheel, so C++ and Python run the very same kernels. The wheel has no
headers; an npm package under the MIT licence carries them. Who has a release tarball of onnxruntime needs none of this.
"""

import argparse
import hashlib
import importlib.metadata
import importlib.util
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path, PurePosixPath

PACKAGE = "com.github.asus4.onnxruntime@0.4.9"
PACKAGE_SHA256 = "e59788788818fdde1b2e522e766a21ba0f7d8391de55737abf81e32cc801785d"
HEADERS = PurePosixPath("package/Plugins/iOS~/onnxruntime.xcframework/ios-arm64/onnxruntime.framework/Headers")
#: Written last: a root that has it is complete. It holds what the root was made from.
STAMP = "made_from.txt"


def main() -> int:
    """Make the root, unless it is there already."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", type=Path, help="folder to make")
    root = parser.parse_args().root
    try:
        print(lay_out(root))
    except FetchError as error:
        print(f"fetch_onnxruntime: {error}", file=sys.stderr)
        return 1
    return 0


class FetchError(Exception):
    """What is missing, and what to do."""


def lay_out(root: Path) -> Path:
    """Fill `root` with include/ and lib/ for the installed wheel; one that is complete is left alone."""
    library = wheel_library()
    made_from = f"{PACKAGE}\n{library.name}\n"
    stamp = root / STAMP
    if stamp.is_file() and stamp.read_text() == made_from:
        return root
    shutil.rmtree(root, ignore_errors=True)
    include, lib = root / "include", root / "lib"
    include.mkdir(parents=True)
    lib.mkdir()
    fetch_headers(include)
    check_versions(include, library)
    shutil.copy2(library, lib / library.name)
    # The names that the loader (the library's SONAME) and the linker look for.
    (lib / "libonnxruntime.so.1").symlink_to(library.name)
    (lib / "libonnxruntime.so").symlink_to("libonnxruntime.so.1")
    stamp.write_text(made_from)
    return root


def wheel_library() -> Path:
    """The shared library inside the installed onnxruntime wheel."""
    spec = importlib.util.find_spec("onnxruntime")
    if spec is None or spec.origin is None:
        raise FetchError("onnxruntime is not installed; run: pip install onnxruntime")
    version = importlib.metadata.version("onnxruntime")
    library = Path(spec.origin).parent / "capi" / f"libonnxruntime.so.{version}"
    if not library.is_file():
        raise FetchError(f"the onnxruntime wheel has no {library.name}; use a release tarball of onnxruntime")
    return library


def fetch_headers(include: Path) -> None:
    """Copy the C and C++ headers of the npm package into `include`."""
    npm = shutil.which("npm")
    if npm is None:
        raise FetchError("npm is not installed; use a release tarball of onnxruntime")
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [npm, "pack", "--silent", PACKAGE], cwd=folder, capture_output=True, text=True, check=False
        )
        tarballs = list(Path(folder).glob("*.tgz"))
        if done.returncode or len(tarballs) != 1:
            reason = (done.stderr.strip().splitlines() or ["no tarball"])[-1]
            raise FetchError(f"npm pack {PACKAGE} failed ({reason})")
        with tarballs[0].open("rb") as file:
            digest = hashlib.sha256()
            while block := file.read(1 << 20):
                digest.update(block)
        if digest.hexdigest() != PACKAGE_SHA256:
            raise FetchError(f"{PACKAGE} is not the package that was reviewed (its SHA-256 differs)")
        with tarfile.open(tarballs[0]) as tarball:
            for member in tarball:
                path = PurePosixPath(member.name)
                content = tarball.extractfile(member) if path.parent == HEADERS and path.suffix == ".h" else None
                if content is not None:
                    (include / path.name).write_bytes(content.read())


def check_versions(include: Path, library: Path) -> None:
    """Refuse headers that ask for a newer interface than the library has: onnxruntime 1.N offers versions up to N."""
    header = include / "onnxruntime_c_api.h"
    asked = re.search(r"#define ORT_API_VERSION (\d+)", header.read_text()) if header.is_file() else None
    if asked is None:
        raise FetchError(f"{PACKAGE} has no onnxruntime_c_api.h with an ORT_API_VERSION")
    offered = re.search(r"\.so\.1\.(\d+)\.", library.name)
    if offered is None or int(asked[1]) > int(offered[1]):
        raise FetchError(
            f"the headers ask for interface {asked[1]}, {library.name} is older; "
            f"run: pip install 'onnxruntime>=1.{asked[1]}'"
        )


if __name__ == "__main__":
    sys.exit(main())
