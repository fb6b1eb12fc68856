"""The journal: a file that grows, of which any beginning that was referred to can be read."""

import errno
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workers.journal import Beginning, Journal, pieces
from workers.sealed_file import DamagedError


def piece(number: int) -> dict[str, np.ndarray]:
    return {"states": np.full((2, 3), number, np.float64), "ends": np.array([True, False])}


def grown(folder: Path, count: int) -> list[Beginning]:
    """A journal of so many pieces, and what could be referred to after each."""
    journal = Journal(folder / "1.journal")
    assert journal.so_far() == []
    beginnings = []
    for number in range(count):
        journal.append(piece(number))
        beginnings += journal.so_far()
    return beginnings


def test_every_beginning_gives_its_pieces(tmp_path: Path) -> None:
    for count, beginning in enumerate(grown(tmp_path, 3), 1):
        read = list(pieces(tmp_path, beginning))
        assert [int(each["states"][0, 0]) for each in read] == list(range(count))
        np.testing.assert_array_equal(read[0]["ends"], piece(0)["ends"], strict=True)


def test_what_a_failed_try_left_is_written_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    journal = Journal(tmp_path / "1.journal")
    journal.append(piece(0))
    before = journal.so_far()

    def fail(descriptor: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", fail)
        with pytest.raises(OSError, match="Input/output"):
            journal.append(piece(1))
    assert journal.so_far() == before
    journal.append(piece(2))
    [beginning] = journal.so_far()
    assert beginning.size == (tmp_path / "1.journal").stat().st_size
    assert [int(each["states"][0, 0]) for each in pieces(tmp_path, beginning)] == [0, 2]


@given(data=st.data())
def test_damaged_anywhere_it_is_refused(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    folder = tmp_path_factory.mktemp("journal")
    first, last = grown(folder, 2)
    file = folder / "1.journal"
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


def test_one_that_is_missing_is_damaged(tmp_path: Path) -> None:
    [beginning] = grown(tmp_path, 1)
    with pytest.raises(DamagedError, match="other is missing"):
        list(pieces(tmp_path, replace(beginning, file="other")))
