"""A bucket of an S3 store, accessed through fsspec; errors are told in words.

Credentials and endpoint come from where AWS's tools look for them (AWS_ACCESS_KEY_ID,
AWS_SECRET_ACCESS_KEY, AWS_ENDPOINT_URL and so on) and are in no message.

Training waits while a checkpoint is written, so a store that does not answer is given up after some
ten seconds, and other requests in the `SILENCE_SECONDS` afterwards fail at once.
"""

import errno
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import fsspec

from workers.checkpoints.folder import UnavailableError, UnreachableError

SCHEME = "s3://"
SILENCE_SECONDS = 5.0
AT_ONCE = 16
"""Concurrent requests of one folder."""
LARGEST_PUT = 5 * 2**30
"""Limit of S3 in bytes; a larger object would be put in parts."""
OPTIONS = {
    "use_listings_cache": False,
    "max_concurrency": 1,
    "config_kwargs": {
        "connect_timeout": 3,
        "read_timeout": 15,
        "retries": {"mode": "standard", "total_max_attempts": 3},
        "max_pool_connections": 32,
        # Not every store knows these checksums, and every file has its SHA-256.
        "request_checksum_calculation": "when_required",
        "response_checksum_validation": "when_required",
    },
}
SILENT = {"ConnectionError", "HTTPClientError", "TimeoutError", "ClientPayloadError"}
"""Of the errors that have no answer, those (and what derives from them) that may pass."""
NO_CREDENTIALS = {
    *("NoCredentialsError", "PartialCredentialsError", "CredentialRetrievalError"),
    *("ProfileNotFound", "TokenRetrievalError", "UnauthorizedSSOTokenError"),
}

T = TypeVar("T")


class Bucket:
    """Objects below one prefix. Safe from any thread; every method raises OSError."""

    def __init__(self, url: str) -> None:
        """Request nothing yet. The URL is `s3://bucket` or `s3://bucket/prefix`."""
        self._url = url
        self._root = url.removeprefix(SCHEME)
        self._refusal = ""
        self._silent_until = 0.0

    def put(self, key: str, content: bytes) -> None:
        """Make or replace an object, whole or not at all."""
        path = self._path(key)
        self._ask(lambda s3: s3.pipe_file(path, content, chunksize=LARGEST_PUT))

    def get(self, keys: Sequence[str]) -> list[bytes]:
        """The contents of objects. Raises FileNotFoundError where one is missing."""
        return self._ask_each(lambda s3, path: s3.cat_file(path), keys)

    def keys(self, beginning: str) -> list[str]:
        """The keys that begin with a text, in order."""
        paths: list[str] = self._ask(lambda s3: s3.find(self._root, prefix=beginning))
        return [path.removeprefix(f"{self._root}/") for path in paths]

    def sizes(self, beginning: str) -> dict[str, int]:
        """The sizes in bytes of the objects whose keys begin with a text, by key."""
        found = self._ask(lambda s3: s3.find(self._root, prefix=beginning, detail=True))
        return {
            path.removeprefix(f"{self._root}/"): int(about["size"]) for path, about in found.items()
        }

    def delete(self, keys: Sequence[str]) -> None:
        """Remove objects."""
        self._ask_each(lambda s3, path: s3.rm_file(path), keys)

    def _path(self, key: str) -> str:
        return f"{self._root}/{key}"

    def _ask_each(self, request: Callable[[Any, str], T], keys: Sequence[str]) -> list[T]:
        def ask(key: str) -> T:
            return self._ask(lambda s3: request(s3, self._path(key)))

        if len(keys) < 2:
            return [ask(key) for key in keys]
        with ThreadPoolExecutor(min(AT_ONCE, len(keys))) as threads:
            return list(threads.map(ask, keys))

    def _ask(self, request: Callable[[Any], T]) -> T:
        if time.monotonic() < self._silent_until:
            raise UnreachableError(errno.EHOSTUNREACH, self._refusal)
        try:
            s3 = fsspec.filesystem("s3", **OPTIONS)  # the same one, once there is one
            s3.retries = 1  # those in OPTIONS do
            return request(s3)
        except Exception as error:  # of four libraries
            refusal = self._in_words(error)
            if isinstance(refusal, UnreachableError):
                self._refusal = str(refusal.strerror)
                self._silent_until = time.monotonic() + SILENCE_SECONDS
        raise refusal  # here, so that nothing of the libraries' own words goes with it

    def _in_words(self, error: Exception) -> OSError:
        answer = getattr(error.__cause__ or error, "response", None)
        kinds = {each.__name__ for each in type(error).__mro__}
        if isinstance(answer, dict):
            return self._answer_in_words(answer)
        if kinds & NO_CREDENTIALS:
            return UnavailableError(
                errno.EACCES,
                f"there are no credentials for {self._url}: set AWS_ACCESS_KEY_ID and "
                "AWS_SECRET_ACCESS_KEY where the service and every worker run",
            )
        if kinds & SILENT:
            return UnreachableError(
                errno.EHOSTUNREACH,
                f"{self._url} does not answer ({type(error).__name__}): check that the "
                "store is up, AWS_ENDPOINT_URL is right, and its host is reachable from here",
            )
        if isinstance(error, ImportError):
            return UnavailableError(
                errno.ENOPKG, "s3fs is missing where this runs: pip install 'd3pg[s3]'"
            )
        return UnavailableError(
            errno.EIO,
            f"{self._url} cannot be used ({type(error).__name__}): check D3PG_CHECKPOINTS and "
            "AWS_ENDPOINT_URL, a URL such as https://s3.example.org",
        )

    def _answer_in_words(self, answer: dict[str, Any]) -> OSError:
        code = answer["Error"].get("Code", "")
        status = answer.get("ResponseMetadata", {}).get("HTTPStatusCode", 0)
        if code == "NoSuchKey":
            return FileNotFoundError(errno.ENOENT, "no such object")
        if status == 404:
            return UnavailableError(
                errno.ENXIO,
                f"the store has no bucket of {self._url} ({code}): make it, or name another with "
                "D3PG_CHECKPOINTS",
            )
        if status in {401, 403}:
            return UnavailableError(
                errno.EACCES,
                f"the store refuses to work on {self._url} ({code}): its credentials must be "
                "right, and allowed to list, get, put and delete there",
            )
        if status == 429 or status >= 500:
            return UnreachableError(
                errno.EAGAIN, f"the store of {self._url} is in trouble or busy ({code or status})"
            )
        return UnavailableError(
            errno.EIO, f"the store of {self._url} refuses the request ({code or status})"
        )
