"""Sealed files: written whole or not at all, and known to be what was written when they are read.

    SHA-256 of the payload in hexadecimal, a line feed, the payload

A file is written under another name, brought to the disk, and then renamed, so that its name never
stands for half of it, whenever the power goes. Payloads are text or arrays (`numpy.savez`, which
takes no objects: nothing is ever unpickled).
"""

import hashlib
import io
import os
from pathlib import Path

import numpy as np

from algorithms.state import State

DIGEST_SIZE = 64


class DamagedError(ValueError):
    """A file is not what was written; its text says how it can be told."""


def write(path: Path, payload: bytes) -> None:
    """Write a sealed file. The folder is yet to be brought to the disk.

    Raises OSError, and leaves nothing behind then.
    """
    digest = hashlib.sha256(payload).hexdigest()
    unfinished = path.with_name(f"{path.name}.unfinished")
    try:
        with unfinished.open("wb") as file:
            file.write(digest.encode() + b"\n")
            file.write(payload)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
    except OSError:
        unfinished.unlink(missing_ok=True)
        raise


def read(path: Path) -> bytes:
    """Read the payload of a sealed file. Raises DamagedError."""
    sealed = read_bytes(path)
    noted, payload = sealed[:DIGEST_SIZE], sealed[DIGEST_SIZE + 1 :]
    if noted != hashlib.sha256(payload).hexdigest().encode():
        raise DamagedError(f"hash mismatch of {path.name}")
    return payload


def read_bytes(path: Path) -> bytes:
    """Read a file. Raises DamagedError where it is missing or the disk fails."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise DamagedError(f"{path.name} is missing") from None
    except OSError as error:
        raise DamagedError(f"{path.name} cannot be read: {error.strerror}") from error


def bring_to_disk(folder: Path) -> None:
    """Make sure that the names in a folder survive a power cut."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def packed(arrays: State) -> bytes:
    """Arrays as a payload. Raises ValueError for arrays of objects."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def unpacked(payload: bytes) -> State:
    """The arrays of a payload. Raises DamagedError for what is none, pickles above all."""
    try:
        with np.load(io.BytesIO(payload), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception as error:  # what readers of archives raise is no closed set
        raise DamagedError(f"no arrays but something else, refused: {error}") from error
