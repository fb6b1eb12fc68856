"""A store that speaks S3, on loopback (moto's)."""

import itertools
from typing import Any

import fsspec
from moto.server import ThreadedMotoServer

from workers.checkpoints import place
from workers.checkpoints.bucket import OPTIONS, SCHEME

SECRET = "a-secret-key-of-tests"  # noqa: S105
NAMES = itertools.count()


class ObjectStore:
    """Keeps its objects while it is stopped."""

    def __init__(self) -> None:
        self._server: Any = None
        self._port = 0

    def start(self) -> None:
        """Listen, where it did before."""
        self._server = ThreadedMotoServer("127.0.0.1", self._port, verbose=False)
        self._server.start()
        _, self._port = self._server.get_host_and_port()

    def stop(self) -> None:
        """Listen no more."""
        self._server.stop()

    @property
    def environment(self) -> dict[str, str]:
        """What AWS's tools have to be told."""
        return {
            "AWS_ENDPOINT_URL": f"http://127.0.0.1:{self._port}",
            "AWS_ACCESS_KEY_ID": "an-access-key-of-tests",
            "AWS_SECRET_ACCESS_KEY": SECRET,
            "AWS_EC2_METADATA_DISABLED": "true",
            "NO_PROXY": "127.0.0.1",
        }

    def new_bucket(self) -> str:
        """The URL of a bucket made just now; the environment must have the way here."""
        name = f"d3pg-{next(NAMES)}"
        objects().mkdir(name)
        return f"{SCHEME}{name}"


def objects() -> Any:
    """All there is, as a file system."""
    return fsspec.filesystem("s3", **OPTIONS)


def forget_clients() -> None:
    """Have the environment read anew."""
    fsspec.get_filesystem_class("s3").clear_instance_cache()
    place._bucket.cache_clear()
