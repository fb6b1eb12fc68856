"""What databases say, told to people."""

import psycopg
import pytest
from sqlalchemy.exc import DBAPIError, InternalError, OperationalError

from service.store.upkeep.trouble import (
    FAILING,
    FULL,
    READ_ONLY,
    UNREACHABLE,
    Trouble,
    explain,
    find_trouble,
)


def sqlite(words: str) -> OperationalError:
    return OperationalError("INSERT", {}, Exception(words))


@pytest.mark.parametrize(
    ("error", "trouble"),
    [
        (sqlite("database or disk is full"), FULL),
        (sqlite("disk I/O error"), FAILING),
        (sqlite("attempt to write a readonly database"), READ_ONLY),
        (sqlite("unable to open database file"), UNREACHABLE),
        (OperationalError("", {}, psycopg.errors.DiskFull()), FULL),
        (OperationalError("", {}, psycopg.errors.IoError()), FAILING),
        (InternalError("", {}, psycopg.errors.ReadOnlySqlTransaction()), READ_ONLY),
        (OperationalError("", {}, psycopg.OperationalError("connection refused")), UNREACHABLE),
    ],
)
def test_trouble_is_told_in_sentences(error: DBAPIError, trouble: Trouble) -> None:
    assert find_trouble(error) == trouble
    assert explain(error) == f"{trouble.fact} {trouble.advice}"


def test_other_errors_speak_for_themselves() -> None:
    assert find_trouble(sqlite("no such table: runs")) is None
    assert explain(sqlite("no such table: runs\nat line 1")) == "no such table: runs"
    assert explain(ValueError("7 is too many")) == "7 is too many"
    assert explain(ValueError()) == "ValueError"
