"""The checks: what they find, and that they say what to do."""

import socket
from pathlib import Path

import pytest
from fastapi import FastAPI
from pydantic import SecretStr

from service.cli.host import checkup
from service.cli.host.checkup import (
    check_checkpoints,
    check_database,
    check_disk,
    check_library,
    check_memory,
    check_port,
    check_python,
    check_token,
    examine,
)
from service.settings import Settings
from service.store.store import Store
from tests.end_to_end.running_service import free_port
from tests.object_store import SECRET
from tests.service.conftest import TOKEN, FakeDispatcher
from tests.service.served import served


def test_python() -> None:
    assert check_python((3, 11, 0)).verdict == "ok"
    old = check_python((3, 10, 9))
    assert (old.verdict, old.found) == ("failed", "3.10.9")
    assert "3.11" in old.advice


def test_a_library_that_is_missing_or_of_another_series(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkup, "LIBRARIES", {"yaml": "99.", "no_such": "1."})
    assert check_library("yaml", "").verdict == "ok"
    assert check_library("yaml", "99.").advice == "pip install 'yaml==99.*'"
    missing = check_library("no_such", "1.")
    assert missing.verdict == "failed"
    assert "No module named 'no_such'" in missing.found


@pytest.mark.parametrize(("gigabytes", "verdict"), [(0.5, "failed"), (1.5, "warning"), (8, "ok")])
def test_memory(gigabytes: float, verdict: str) -> None:
    finding = check_memory(gigabytes * 1e9)
    assert finding.verdict == verdict
    assert bool(finding.advice) == (verdict != "ok")


def test_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert check_disk(tmp_path / "not" / "made").verdict == "ok"
    monkeypatch.setattr(checkup, "LEAST_FREE", 1e18)
    assert check_disk(tmp_path).verdict == "failed"
    (tmp_path / "file").touch()
    assert "cannot be written" in check_disk(tmp_path / "file").found


def test_checkpoints(bucket: str, tmp_path: Path) -> None:
    assert check_checkpoints(tmp_path / "not-made").verdict == "ok"
    assert check_checkpoints(f"{bucket}/lab").verdict == "ok"
    finding = check_checkpoints("s3://no-such-bucket")
    assert finding.verdict == "failed"
    assert "make it, or name another with D3PG_CHECKPOINTS" in finding.found
    assert SECRET not in f"{finding}"


def test_token(tmp_path: Path) -> None:
    file = tmp_path / "token"
    assert check_token(file).verdict == "ok"
    file.touch(0o600)
    assert check_token(file).verdict == "ok"
    file.chmod(0o644)
    assert "chmod 600" in check_token(file).advice


def test_database(settings: Settings, store: Store, tmp_path: Path) -> None:
    del store  # it made the tables
    assert check_database(settings.store_url).found.endswith("d3pg.sqlite, 0 runs")
    assert check_database(f"sqlite:///{tmp_path}/new.sqlite").found.endswith("not made yet")
    (tmp_path / "other.sqlite").write_bytes(b"no database" * 100)
    broken = check_database(f"sqlite:///{tmp_path}/other.sqlite")
    assert broken.verdict == "failed"
    assert "not a database" in broken.found
    away = check_database("postgresql+psycopg://me:secret@127.0.0.1:1/d3pg")
    assert away.verdict == "failed"
    assert "secret" not in away.found + away.advice


def test_port_free_ours_and_somebody_elses(
    app: FastAPI, dispatcher: FakeDispatcher, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("D3PG_TOKEN", TOKEN)
    with socket.socket() as other, monkeypatch.context() as patience:
        other.bind(("127.0.0.1", free_port()))
        other.listen()
        taken = Settings(port=other.getsockname()[1])
        patience.setattr(checkup, "ANSWER_SECONDS", 0.1)
        assert "--port" in check_port(taken).advice
    assert check_port(taken).verdict == "ok"
    with served(app) as url:
        ours = Settings(port=int(url.rpartition(":")[2]), token=SecretStr(TOKEN))
        assert check_port(ours).found.endswith("and is ready")
        dispatcher.problem = "cluster starting"
        assert check_port(ours).verdict == "warning"
        assert "cluster starting" in check_port(ours).found


def test_settings_that_cannot_be_read_end_the_examination(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("D3PG_PORT", "many")
    monkeypatch.setattr(checkup, "LIBRARIES", {})
    *_, last = examine()
    assert last.verdict == "failed"
    assert "D3PG_PORT" in last.found
