"""A bucket's troubles, in words: what was wrong, what to do, and no secret."""

import errno
import socket
import time
from collections.abc import Iterator
from typing import Any

import fsspec
import pytest
from botocore.exceptions import ClientError, ReadTimeoutError

from tests.object_store import SECRET, ObjectStore
from workers.checkpoints import bucket as module
from workers.checkpoints.bucket import Bucket
from workers.checkpoints.folder import UnavailableError, UnreachableError


@pytest.fixture
def closed_port() -> Iterator[int]:
    """A port of loopback that nobody listens on."""
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        yield holder.getsockname()[1]


class Refusing:
    """A file system that answers every request with an error, and counts them."""

    def __init__(self, error: Exception) -> None:
        self.error = error
        self.asked = 0

    def pipe_file(self, *_: Any, **__: Any) -> None:
        self.asked += 1
        raise self.error


def answer(status: int, code: str) -> ClientError:
    message = {"Code": code, "Message": SECRET}
    return ClientError(
        {"Error": message, "ResponseMetadata": {"HTTPStatusCode": status}},
        "PutObject",
    )


def refused(monkeypatch: pytest.MonkeyPatch, error: Exception) -> UnavailableError:
    """What is raised where the libraries raise this."""
    monkeypatch.setattr(fsspec, "filesystem", lambda *_, **__: Refusing(error))
    with pytest.raises(UnavailableError) as refusal:
        Bucket("s3://runs/lab").put("run-3/policy", b"")
    assert SECRET not in str(refusal.value)
    assert refusal.value.__cause__ is None
    assert refusal.value.__context__ is None
    return refusal.value


def test_objects_are_put_listed_got_and_deleted(bucket: str) -> None:
    place = Bucket(f"{bucket}/lab")
    keys = [f"run-3/{number}" for number in range(40)]
    for number, key in enumerate(keys):
        place.put(key, bytes([number]))
    place.put("run-30/1", b"other")
    assert place.keys("run-3/") == sorted(keys)
    assert place.get(keys) == [bytes([number]) for number in range(40)]
    place.delete(keys)
    place.delete(keys)
    assert place.keys("run-3/") == []
    assert place.keys("") == Bucket(f"{bucket}/lab").keys("run-30/") == ["run-30/1"]
    assert Bucket(bucket).keys("lab/") == ["lab/run-30/1"]


def test_a_missing_object_is_a_missing_file(bucket: str) -> None:
    Bucket(bucket).put("a", b"")
    with pytest.raises(FileNotFoundError):
        Bucket(bucket).get(["a", "b"])


@pytest.mark.usefixtures("bucket")
def test_a_missing_bucket_is_named() -> None:
    missing = Bucket("s3://no-such-bucket/lab")
    for ask in (lambda: missing.put("a", b""), lambda: missing.keys("a"), lambda: missing.get("a")):
        with pytest.raises(UnavailableError, match="no bucket of s3://no-such-bucket/lab") as said:
            ask()
        assert "make it, or name another with D3PG_CHECKPOINTS" in str(said.value)
        assert not isinstance(said.value, UnreachableError)


@pytest.mark.usefixtures("fresh_clients")
def test_a_store_that_is_gone_is_told_and_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    store = ObjectStore()
    store.start()
    for name, value in store.environment.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(module, "SILENCE_SECONDS", 0.0)
    place = Bucket(store.new_bucket())
    place.put("a", b"before")
    store.stop()
    with pytest.raises(UnreachableError, match="does not answer") as said:
        place.put("a", b"meanwhile")
    assert "AWS_ENDPOINT_URL" in str(said.value)
    store.start()
    assert place.get(["a"]) == [b"before"]
    store.stop()


def test_while_it_does_not_answer_nobody_waits_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    refusing = Refusing(ReadTimeoutError(endpoint_url="http://store"))
    monkeypatch.setattr(fsspec, "filesystem", lambda *_, **__: refusing)
    place = Bucket("s3://runs")
    for _ in range(3):
        with pytest.raises(UnreachableError, match="does not answer"):
            place.put("a", b"")
    assert refusing.asked == 1
    now = time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now + module.SILENCE_SECONDS + 1)
    with pytest.raises(UnreachableError):
        place.put("a", b"")
    assert refusing.asked == 2


@pytest.mark.usefixtures("bucket", "fresh_clients")
def test_without_credentials_it_says_which_to_set(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.delenv(name)
    for name in ("AWS_CONFIG_FILE", "AWS_SHARED_CREDENTIALS_FILE"):
        monkeypatch.setenv(name, str(tmp_path / "none"))
    with pytest.raises(UnavailableError, match="no credentials for s3://runs: set AWS_ACCESS_KEY"):
        Bucket("s3://runs").keys("run-3/")


@pytest.mark.usefixtures("bucket", "fresh_clients")
def test_a_wrong_endpoint_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", "nonsense")
    with pytest.raises(UnavailableError, match="AWS_ENDPOINT_URL, a URL such as"):
        Bucket("s3://runs").keys("run-3/")


@pytest.mark.usefixtures("bucket", "fresh_clients")
def test_a_port_that_nobody_listens_on_is_told(
    monkeypatch: pytest.MonkeyPatch, closed_port: int
) -> None:
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{closed_port}")
    with pytest.raises(UnreachableError, match="check that the store is up") as said:
        Bucket("s3://runs").keys("run-3/")
    assert SECRET not in str(said.value)


@pytest.mark.parametrize("code", ["AccessDenied", "InvalidAccessKeyId", "SignatureDoesNotMatch"])
def test_refused_credentials_are_told(monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    said = refused(monkeypatch, answer(403, code)).strerror
    assert said == (
        f"the store refuses to work on s3://runs/lab ({code}): its credentials must be right, and "
        "allowed to list, get, put and delete there"
    )


@pytest.mark.parametrize(("status", "code"), [(500, "InternalError"), (503, "SlowDown"), (429, "")])
def test_a_store_in_trouble_may_be_asked_again(
    monkeypatch: pytest.MonkeyPatch, status: int, code: str
) -> None:
    said = refused(monkeypatch, answer(status, code))
    assert isinstance(said, UnreachableError)
    assert f"in trouble or busy ({code or status})" in str(said)


def test_whatever_else_it_answers_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "(EntityTooLarge)" in str(refused(monkeypatch, answer(400, "EntityTooLarge")))
    assert "(KeyError)" in str(refused(monkeypatch, KeyError(SECRET)))
    missing = refused(monkeypatch, ImportError("Install s3fs to access S3"))
    assert (missing.errno, "pip install 'd3pg[s3]'" in str(missing)) == (errno.ENOPKG, True)
