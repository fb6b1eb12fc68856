"""Where the folders of runs are: a folder of the disk or of a shared mount, or a bucket."""

import re
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from workers.checkpoints.bucket import SCHEME, Bucket
from workers.checkpoints.bucket_folder import BucketFolder
from workers.checkpoints.disk_folder import DiskFolder
from workers.checkpoints.folder import Folder

Place = str | Path
"""A path, or the URL of a bucket with or without a prefix."""
BUCKET = re.compile(r"s3://[a-z0-9][a-z0-9.-]{1,61}[a-z0-9](/[\w!.'()-]+)*", re.ASCII)


def place_of(text: str) -> Place:
    """The place that an operator names. Raises ValueError for anything else."""
    scheme, separator, rest = text.partition("://")
    if not separator:
        return Path(text).absolute()
    if scheme == "file" and rest.startswith("/"):
        return Path(rest).absolute()
    url = text.rstrip("/")
    if not BUCKET.fullmatch(url):
        raise ValueError(  # without the text, which may hold a secret
            "a place is a folder's path or s3://BUCKET or s3://BUCKET/PREFIX, of letters, digits "
            "and any of -_.!'() in the prefix; credentials and endpoint have variables of their "
            "own, such as AWS_ACCESS_KEY_ID and AWS_ENDPOINT_URL"
        )
    if find_spec("s3fs") is None:
        raise ValueError("s3fs is missing, here and wherever workers run: pip install 'd3pg[s3]'")
    return url


def folder_in(place: Place, run_id: str) -> Folder:
    """The folder of a run. Raises ValueError for an invalid name."""
    if not re.fullmatch(r"[\w-]+", run_id, re.ASCII):
        raise ValueError(f"the name of a run must not be a path, got {run_id!r}")
    if isinstance(place, str) and place.startswith(SCHEME):
        return BucketFolder(_bucket(place), run_id)
    return DiskFolder(Path(place) / run_id)


@cache
def _bucket(url: str) -> Bucket:
    """One of each in a process, so that all users know when it does not answer."""
    return Bucket(url)
