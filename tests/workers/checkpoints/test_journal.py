"""The journal: a file that grows, of which any beginning that was referred to can be read."""

import errno
import os
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workers.checkpoints.disk_folder import DiskFolder
from workers.checkpoints.folder import Folder
from workers.checkpoints.journal import Beginning, Journal, pieces
from workers.checkpoints.place import Place, folder_in
from workers.checkpoints.sealed_file import DamagedError


def piece(number: int) -> dict[str, np.ndarray]:
    return {"states": np.full((2, 3), number, np.float64), "ends": np.array([True, False])}


@pytest.fixture
def folder(place: Place) -> Folder:
    return folder_in(place, "run-3")


def grown(folder: Folder, count: int) -> list[Beginning]:
    """A journal of so many pieces, and what could be referred to after each."""
    journal = Journal(folder, "1.journal")
    assert journal.so_far() == []
    beginnings = []
    for number in range(count):
        journal.append(piece(number))
        beginnings += journal.so_far()
    return beginnings


def test_every_beginning_gives_its_pieces(folder: Folder) -> None:
    for count, beginning in enumerate(grown(folder, 3), 1):
        read = list(pieces(folder, beginning))
        assert [int(each["states"][0, 0]) for each in read] == list(range(count))
        np.testing.assert_array_equal(read[0]["ends"], piece(0)["ends"], strict=True)


def test_what_could_not_be_appended_is_no_part_of_it(
    folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal = Journal(folder, "1.journal")
    journal.append(piece(0))
    before = journal.so_far()

    def fail(*_: object) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with monkeypatch.context() as patched:
        patched.setattr(type(folder), "append", fail)
        with pytest.raises(OSError, match="Input/output"):
            journal.append(piece(1))
    assert journal.so_far() == before
    journal.append(piece(2))
    [beginning] = journal.so_far()
    assert [int(each["states"][0, 0]) for each in pieces(folder, beginning)] == [0, 2]


@given(data=st.data())
def test_damaged_anywhere_it_is_refused(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("journal")
    folder, file = DiskFolder(path), path / "1.journal"
    first, last = grown(folder, 2)
    whole = file.read_bytes()
    place = data.draw(st.integers(0, len(whole) - 1))
    if data.draw(st.booleans()):
        file.write_bytes(whole[:place])
    else:
        flipped = whole[place] ^ data.draw(st.integers(1, 255))
        file.write_bytes(whole[:place] + bytes([flipped]) + whole[place + 1 :])
    with pytest.raises(DamagedError, match=r"hash mismatch of 1\.journal"):
        list(pieces(folder, last))
    if place >= first.size:
        assert len(list(pieces(folder, first))) == 1


def test_one_that_is_missing_is_damaged(folder: Folder) -> None:
    [beginning] = grown(folder, 1)
    with pytest.raises(DamagedError, match="other is missing"):
        list(pieces(folder, replace(beginning, file="other")))
