"""Databases that cannot be opened: a sentence says what was found, and another what to do."""

from types import SimpleNamespace
from typing import Any

import pytest

from service.refusal import RefusalError
from service.store.refusal import UnfitServerError, UnusableDatabaseError
from service.store.store import Store
from service.store.unusable import refuse_unfit
from tests.service.store.postgresql import PostgreSQL


def refusal(url: str) -> str:
    with pytest.raises(RefusalError) as refused:
        Store.open(url)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_an_encoding_that_holds_no_umlaut(postgresql: PostgreSQL) -> None:
    postgresql.execute("CREATE DATABASE ascii ENCODING 'SQL_ASCII' TEMPLATE template0 LOCALE 'C'")
    said = refusal(postgresql.url("ascii"))
    assert "the database ascii has the encoding SQL_ASCII, where the service needs" in said
    assert "createdb --owner=d3pg --encoding=UTF8 --template=template0" in said


def test_a_database_that_is_missing(postgresql: PostgreSQL) -> None:
    said = refusal(postgresql.url("nowhere"))
    assert 'database "nowhere" does not exist' in said
    assert said.endswith("createdb --owner=d3pg --encoding=UTF8 --template=template0 nowhere")


def test_a_user_that_is_missing(postgresql: PostgreSQL) -> None:
    said = refusal(postgresql.url("postgres", user="nobody_known"))
    assert said.endswith("createuser --pwprompt nobody_known")


def test_a_user_who_may_make_no_table(postgresql: PostgreSQL) -> None:
    postgresql.execute("CREATE ROLE guest LOGIN")
    postgresql.create("of_another")
    said = refusal(postgresql.url("of_another", user="guest"))
    assert "permission denied for schema public" in said
    assert "ALTER DATABASE of_another OWNER TO guest" in said
    postgresql.execute("ALTER DATABASE of_another OWNER TO guest")  # as it says
    Store.open(postgresql.url("of_another", user="guest")).close()


def test_tables_that_another_user_made(postgresql: PostgreSQL) -> None:
    postgresql.execute("CREATE ROLE heir LOGIN")
    Store.open(postgresql.create("inherited")).close()
    postgresql.execute("ALTER DATABASE inherited OWNER TO heir")
    said = refusal(postgresql.url("inherited", user="heir"))
    assert "permission denied" in said
    assert "psql inherited -c 'REASSIGN OWNED BY OTHER TO heir'" in said


@pytest.mark.parametrize("password", ["", ":wrong"])
def test_a_password_that_is_wrong_or_missing(
    postgresql: PostgreSQL, monkeypatch: pytest.MonkeyPatch, password: str
) -> None:
    monkeypatch.setenv("PGPASSFILE", "/dev/null")
    if "locked" not in postgresql.databases:
        postgresql.create("locked")
        postgresql.execute("CREATE ROLE keeper LOGIN PASSWORD 'right'")
        postgresql.ask_passwords_of("locked")
    said = refusal(postgresql.url("locked", user=f"keeper{password}"))
    assert "Write the password of keeper into ~/.pgpass" in said
    assert "wrong" not in said


def test_a_server_that_takes_no_writes(postgresql: PostgreSQL) -> None:
    url = postgresql.create("standby")
    postgresql.execute("ALTER DATABASE standby SET default_transaction_read_only = on")
    assert refusal(url).endswith("name the primary server.")


def test_a_server_that_is_not_there(tmp_path: Any) -> None:
    said = refusal(f"postgresql+psycopg://d3pg:secret@/d3pg?host={tmp_path}")
    assert said.endswith("Check that the server is up and that D3PG_DATABASE_URL is right.")
    assert "secret" not in said


@pytest.mark.parametrize(
    ("version", "encoding", "found"),
    [
        (130_012, "UTF8", "has PostgreSQL 13, where"),
        (170_002, "LATIN1", "has the encoding LATIN1, where"),
        (90_600, "SQL_ASCII", "has PostgreSQL 9 and the encoding SQL_ASCII, where"),
    ],
)
def test_all_that_is_unfit_is_told_at_once(version: int, encoding: str, found: str) -> None:
    closed = []
    info = SimpleNamespace(
        server_version=version,
        dbname="d3pg",
        user="d3pg",
        parameter_status=lambda name: {"server_encoding": encoding}[name],
    )
    connection = SimpleNamespace(info=info, close=lambda: closed.append(True))
    with pytest.raises(UnfitServerError, match=found):
        refuse_unfit(connection)
    assert closed


def test_a_server_without_room(postgresql: PostgreSQL) -> None:
    url = postgresql.create("full_of_others")
    postgresql.execute("ALTER DATABASE full_of_others CONNECTION LIMIT 0")
    postgresql.execute("CREATE ROLE visitor LOGIN")
    with pytest.raises(UnusableDatabaseError, match=r"too many connections.*up to 17 connections"):
        Store.open(url.replace("d3pg@", "visitor@"))
