"""A folder on a disk: what is left where the disk fails, and who may read it."""

import errno
import os
import stat
from pathlib import Path

import pytest

from workers.checkpoints.disk_folder import DiskFolder


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """A disk that takes nothing in; `undo` mends it."""

    def fail(descriptor: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fsync", fail)
    return monkeypatch


def test_a_failed_write_leaves_the_file_and_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    folder = DiskFolder(tmp_path)
    folder.write("file", b"content")
    request.getfixturevalue("failing")
    with pytest.raises(OSError, match="Input/output"):
        folder.write("file", b"other")
    monkeypatch.undo()
    assert folder.read("file") == b"content"
    assert folder.names() == ["file"]


def test_what_a_failed_append_left_is_written_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    folder = DiskFolder(tmp_path)
    folder.append("1.journal", 0, b"one")
    request.getfixturevalue("failing")
    with pytest.raises(OSError, match="Input/output"):
        folder.append("1.journal", 3, b"a longer one")
    monkeypatch.undo()
    folder.append("1.journal", 3, b"two")
    assert folder.read("1.journal") == b"onetwo"


def test_files_and_their_names_are_brought_to_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[str] = []
    sync = os.fsync

    def note(descriptor: int) -> None:
        synced.append(Path(os.readlink(f"/proc/self/fd/{descriptor}")).name)
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", note)
    folder = DiskFolder(tmp_path / "run-3")
    folder.append("1.journal", 0, b"one")
    folder.write("1-200.checkpoint", b"state")
    assert synced == ["1.journal", "1-200.checkpoint.unfinished", "run-3"]


def test_it_is_its_users_alone(tmp_path: Path) -> None:
    DiskFolder(tmp_path / "run-3").append("1.journal", 0, b"one")
    assert stat.S_IMODE((tmp_path / "run-3").stat().st_mode) == 0o700
    assert stat.S_IMODE((tmp_path / "run-3" / "1.journal").stat().st_mode) == 0o600
