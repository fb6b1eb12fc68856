"""Sealed files: whole or refused."""

import contextlib
import errno
import io
import os
import pickle
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workers.checkpoints import sealed_file
from workers.checkpoints.disk_folder import DiskFolder
from workers.checkpoints.folder import UnreachableError
from workers.checkpoints.sealed_file import DamagedError, read_damage

PAYLOAD = bytes(range(256)) * 3


def test_gives_back_what_was_written(tmp_path: Path) -> None:
    folder = DiskFolder(tmp_path)
    sealed_file.write(folder, "file", PAYLOAD)
    assert sealed_file.read(folder, "file") == PAYLOAD
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


def test_cut_anywhere_it_is_refused(tmp_path: Path) -> None:
    folder, path = DiskFolder(tmp_path), tmp_path / "file"
    sealed_file.write(folder, "file", PAYLOAD)
    whole = path.read_bytes()
    for size in range(len(whole)):
        path.write_bytes(whole[:size])
        with pytest.raises(DamagedError, match="hash mismatch of file"):
            sealed_file.read(folder, "file")


def test_with_a_bit_flipped_anywhere_it_is_refused(tmp_path: Path) -> None:
    folder, path = DiskFolder(tmp_path), tmp_path / "file"
    sealed_file.write(folder, "file", PAYLOAD)
    whole = path.read_bytes()
    for place in [*range(sealed_file.DIGEST_SIZE), *range(sealed_file.DIGEST_SIZE + 1, len(whole))]:
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 4]) + whole[place + 1 :])
        with pytest.raises(DamagedError, match="hash mismatch of file"):
            sealed_file.read(folder, "file")


def test_what_is_missing_is_damaged(tmp_path: Path) -> None:
    with pytest.raises(DamagedError, match="other is missing"):
        sealed_file.read(DiskFolder(tmp_path), "other")


def test_what_cannot_be_read_is_damaged_but_not_where_its_place_cannot_be_had() -> None:
    with (
        pytest.raises(DamagedError, match="file cannot be read: Input/output error"),
        read_damage("file"),
    ):
        raise OSError(errno.EIO, os.strerror(errno.EIO))
    with pytest.raises(UnreachableError), read_damage("file"):
        raise UnreachableError(errno.EHOSTUNREACH, "the store does not answer")


def test_arrays_survive_to_the_bit() -> None:
    arrays = {
        "a/theta": np.array([0.1, np.nan, np.inf, -0.0], np.float32),
        "count": np.array(2**60),
        "ends": np.array([[True], [False]]),
        "none": np.empty((0, 3)),
    }
    found = sealed_file.unpacked(sealed_file.packed(arrays))
    assert found.keys() == arrays.keys()
    for name, array in arrays.items():
        np.testing.assert_array_equal(found[name], array, strict=True)


class Hostile:
    """A pickle that runs code when it is read."""

    def __init__(self, canary: Path) -> None:
        self.canary = canary

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.canary,)


def test_a_pickle_is_refused_and_no_code_of_it_runs(tmp_path: Path) -> None:
    canary = tmp_path / "canary"
    within = tmp_path / "arrays.npz"
    np.savez(within, a=np.array([Hostile(canary)], dtype=object))
    for payload in (pickle.dumps(Hostile(canary)), within.read_bytes(), b"", b"PK\x03\x04"):
        with pytest.raises(DamagedError, match="refused"):
            sealed_file.unpacked(payload)
    assert not canary.exists()
    pickle.loads(pickle.dumps(Hostile(canary)))  # noqa: S301  (it would have run)
    assert canary.exists()


@given(data=st.data())
def test_whatever_bytes_they_are_arrays_are_read_or_refused(data: st.DataObject) -> None:
    """A seal proves who wrote, not that he wrote arrays; compressed ones fail in more ways."""
    buffer = io.BytesIO()
    write = data.draw(st.sampled_from([np.savez, np.savez_compressed]))
    write(buffer, a=np.arange(7.0), b=np.array([True, False]))
    payload = bytearray(buffer.getvalue())
    for place in data.draw(st.lists(st.integers(0, len(payload) - 1), max_size=3)):
        payload[place] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(payload)))
    with contextlib.suppress(DamagedError):
        sealed_file.unpacked(bytes(payload[:cut]))
    with contextlib.suppress(DamagedError):
        sealed_file.unpacked(bytes(payload))


@pytest.mark.parametrize(
    "error", [zlib.error("x"), NotImplementedError("x"), MemoryError(), RuntimeError("encrypted")]
)
def test_whatever_the_reader_raises_the_file_is_damaged(
    monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(np, "load", fail)
    with pytest.raises(DamagedError, match="refused"):
        sealed_file.unpacked(b"")


def test_objects_are_not_written() -> None:
    with pytest.raises(ValueError, match="allow_pickle=False"):
        sealed_file.packed({"a": np.array([{}], dtype=object)})
