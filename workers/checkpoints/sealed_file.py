"""Sealed files: written completely or not at all, and verified when they are read.

    SHA-256 of the payload in hexadecimal, a line feed, the payload

The folder ensures the first, the digest the second. Payloads are text or arrays (`numpy.savez`,
which takes no objects: nothing is ever unpickled).
"""

import hashlib
import io
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from algorithms.state import State
from workers.checkpoints.folder import Folder, UnavailableError

DIGEST_SIZE = 64


class DamagedError(ValueError):
    """A file differs from what was written; the text says how."""


def write(folder: Folder, name: str, payload: bytes) -> None:
    """Write a sealed file. Raises OSError."""
    digest = hashlib.sha256(payload).hexdigest()
    folder.write(name, digest.encode() + b"\n" + payload)


def read(folder: Folder, name: str) -> bytes:
    """Read the payload of a sealed file. Raises DamagedError, UnavailableError."""
    with read_damage(name):
        sealed = folder.read(name)
    noted, payload = sealed[:DIGEST_SIZE], sealed[DIGEST_SIZE + 1 :]
    if noted != hashlib.sha256(payload).hexdigest().encode():
        raise DamagedError(f"hash mismatch of {name}")
    return payload


@contextmanager
def read_damage(name: str) -> Iterator[None]:
    """Raise DamagedError if a file that is being read is missing or the disk fails."""
    try:
        yield
    except UnavailableError:
        raise
    except FileNotFoundError:
        raise DamagedError(f"{name} is missing") from None
    except OSError as error:
        raise DamagedError(f"{name} cannot be read: {error.strerror}") from error


def packed(arrays: State) -> bytes:
    """Arrays as a payload. Raises ValueError for arrays of objects."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def unpacked(payload: bytes) -> State:
    """The arrays of a payload. Raises DamagedError for anything else, above all pickles."""
    try:
        with np.load(io.BytesIO(payload), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except Exception as error:  # what readers of archives raise is no closed set
        raise DamagedError(f"not arrays, refused: {error}") from error
