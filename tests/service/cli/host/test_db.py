"""`d3pg db` as an operator calls it, on both databases."""

import json
from pathlib import Path

import pytest
from sqlalchemy import text
from typer.testing import CliRunner

from service.cli.app import app
from service.data_dir import owned
from service.store.connection import connect
from service.store.store import Store
from tests.service.store.postgresql import running_postgresql
from workers.messages.run_spec import RunSpec


@pytest.fixture
def url(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The database of a service in this data directory, with one sweep."""
    monkeypatch.setenv("D3PG_DATA_DIR", str(tmp_path))
    monkeypatch.delenv("D3PG_DATABASE_URL", raising=False)
    address = f"sqlite:///{tmp_path / 'd3pg.sqlite'}"
    store = Store.open(address)
    specs = [RunSpec("ddpg", "Pendulum", seed) for seed in range(3)]
    store.create_sweep("x", 0, {}, specs, environment_versions={"Pendulum": 1})
    store.close()
    return address


def run(*words: str, code: int = 0) -> str:
    result = CliRunner().invoke(app, ["db", *words])
    assert result.exit_code == code, result.output
    return " ".join(result.output.split())


def damage(url: str) -> None:
    engine = connect(url, "writer")
    with engine.begin() as connection:
        connection.execute(text("UPDATE runs SET attempt = 1"))
    engine.dispose()


def test_check_says_what_holds_and_what_does_not(url: str) -> None:
    assert "broken" not in run("check")
    damage(url)
    said = run("check", code=1)
    assert "broken a run has as many attempts as it was claimed 3 rows break it" in said


def test_backup_and_its_check(url: str, tmp_path: Path) -> None:
    file = tmp_path / "kept.sqlite"
    assert str(file) in run("backup", str(file))
    assert "broken" not in run("check", "--database-url", f"sqlite:///{file}")
    assert "overwrites nothing" in run("backup", str(file), code=1)
    assert "pg_dump" in run("backup", "x", "--database-url", "postgresql:///x", code=2)


def test_every_command_answers_in_json(url: str, tmp_path: Path) -> None:
    assert json.loads(run("upgrade", "--json"))["is_upgraded"] is True
    assert not any(check["faults"] for check in json.loads(run("check", "--json")))
    file = tmp_path / "kept.sqlite"
    assert json.loads(run("backup", str(file), "--json")) == {"file": str(file)}
    copied = json.loads(run("copy", url, f"sqlite:///{tmp_path / 'b' / 'd3pg.sqlite'}", "--json"))
    assert {table["name"]: table["rows"] for table in copied}["runs"] == 3
    damage(url)
    [broken] = [check for check in json.loads(run("check", "--json", code=1)) if check["faults"]]
    assert broken["faults"] == ["3 rows break it"]


def test_copies_there_and_back_are_equal(url: str, tmp_path: Path) -> None:
    with running_postgresql() as server:
        there = server.create("d3pg")
        first = run("copy", url, there)
        second = run("copy", there, f"sqlite:///{tmp_path / 'back' / 'd3pg.sqlite'}")
        assert "runs 3 rows sha256" in first
        assert first == second
        assert "not empty" in run("copy", url, there, code=1)


def test_a_database_in_use_is_neither_copied_nor_upgraded(url: str, tmp_path: Path) -> None:
    with owned(tmp_path):
        assert "another service works in" in run("upgrade", code=1)
        assert "another service works in" in run(
            "copy", url, f"sqlite:///{tmp_path / 'x.sqlite'}", code=1
        )
        assert "broken" not in run("check")


def test_a_folder_of_all_users_stays_as_it_is(tmp_path: Path) -> None:
    folder = tmp_path / "shared"
    folder.mkdir()
    folder.chmod(0o1777)
    assert "of this version" in run("upgrade", "--database-url", f"sqlite:///{folder / 'x.sqlite'}")
    assert folder.stat().st_mode & 0o7777 == 0o1777
    assert [each.name for each in folder.iterdir()] == ["x.sqlite"]


def test_what_is_not_there_is_not_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("D3PG_DATA_DIR", str(tmp_path))
    assert "there is no database" in run("check", code=1)
    assert list(tmp_path.iterdir()) == []
    assert "of this version" in run("upgrade")
    assert "broken" not in run("check")
