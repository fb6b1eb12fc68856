"""The terms of a service: what is no terms of this format is refused in a sentence."""

import json

import pytest

from workers.driver.placement import Bounds
from workers.driver.terms import Terms, UnusableTermsError
from workers.messages.report import FORMAT

TERMS = Terms("head:6379", least=1, most=16, worker_bytes=10**9, checkpoints="s3://bucket/prefix")


def test_terms_are_read_as_they_were_written() -> None:
    line = TERMS.to_line()
    assert line.endswith(b"\n")
    assert Terms.from_line(line) == TERMS
    assert TERMS.bounds == Bounds(1, 16)


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"GET / HTTP/1.1\r\n",
        b"3",
        b"[]",
        b"{}",
        b"[" * 100_000,
        json.dumps({"format": FORMAT}).encode(),
        json.dumps({"format": FORMAT, "terms": {"address": ""}}).encode(),
        b'{"do": "close"}',
    ],
)
def test_anything_else_is_refused(line: bytes) -> None:
    with pytest.raises(UnusableTermsError, match="did not say what it asks for"):
        Terms.from_line(line)


def test_a_service_of_another_version_is_told_so() -> None:
    line = TERMS.to_line().replace(b'"format": %d' % FORMAT, b'"format": %d' % (FORMAT + 1))
    expected = f"speaks format {FORMAT + 1} and this process format {FORMAT}: start both from"
    with pytest.raises(UnusableTermsError, match=expected):
        Terms.from_line(line)
