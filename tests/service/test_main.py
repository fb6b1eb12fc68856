"""`python -m service`: a refusal to start is a sentence and exit code 2, and nothing is started."""

import json
import os
import re
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import pytest
from fastapi import FastAPI

import service.__main__ as main_module
from service.data_dir import make_private
from service.listening import listen
from service.store.store import Store

ROOT = Path(__file__).parents[2]


def started(data_dir: Path, **settings: object) -> "subprocess.CompletedProcess[str]":
    own = {"D3PG_DATA_DIR": data_dir, "D3PG_PORT": 0, "PYTHONPATH": ROOT, **settings}
    return subprocess.run(
        [sys.executable, "-m", "service"],
        env=os.environ | {name: str(value) for name, value in own.items()},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def is_a_file(data_dir: Path) -> None:
    data_dir.touch()


def has_a_token_for_everybody(data_dir: Path) -> None:
    make_private(data_dir)
    (data_dir / "token").write_text("0" * 48)
    (data_dir / "token").chmod(0o644)


def comes_from_the_future(data_dir: Path) -> None:
    make_private(data_dir)
    Store.open(f"sqlite:///{data_dir}/d3pg.sqlite").close()
    with sqlite3.connect(data_dir / "d3pg.sqlite") as database:
        database.execute("UPDATE alembic_version SET version_num = '0099'")
    database.close()


def was_cut_short(data_dir: Path) -> None:
    make_private(data_dir)
    file = data_dir / "d3pg.sqlite"
    Store.open(f"sqlite:///{file}").close()
    file.write_bytes(file.read_bytes()[:9000])


def is_no_database(data_dir: Path) -> None:
    make_private(data_dir)
    (data_dir / "d3pg.sqlite").write_bytes(b"no database " * 1000)


@pytest.mark.parametrize(
    ("prepare", "sentence"),
    [
        (is_a_file, "is a file: choose a directory"),
        (has_a_token_for_everybody, "chmod 600"),
        (comes_from_the_future, "revision 0099, which this version does not know"),
        (was_cut_short, "cannot be opened as a database: database disk image is malformed"),
        (is_no_database, "cannot be opened as a database: file is not a database"),
    ],
)
def test_a_data_directory_that_cannot_be_used(
    tmp_path: Path, prepare: Callable[[Path], None], sentence: str
) -> None:
    prepare(tmp_path / "data")
    done = started(tmp_path / "data")
    assert sentence in done.stderr
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "signin" not in done.stdout


def test_a_taken_port(tmp_path: Path) -> None:
    with listen("127.0.0.1", 0) as other:
        done = started(tmp_path / "data", D3PG_PORT=other.getsockname()[1])
    assert done.returncode == 2
    assert done.stdout == ""
    [line] = done.stderr.splitlines()
    assert "something else listens there" in line
    assert not (tmp_path / "data").exists()


def test_several_wrong_settings_are_all_told(tmp_path: Path) -> None:
    done = started(tmp_path, D3PG_WORKERS="none", D3PG_DATABASE_URL="elsewhere")
    assert done.returncode == 2
    assert {line.split(":")[0] for line in done.stderr.splitlines()} == {
        "D3PG_WORKERS",
        "D3PG_DATABASE_URL",
    }


@pytest.mark.parametrize("key", ["none.pem", "token"])
def test_a_certificate_that_cannot_be_used(tmp_path: Path, key: str) -> None:
    (tmp_path / "token").write_text("no key")
    done = started(
        tmp_path / "data",
        D3PG_TLS_CERTIFICATE=tmp_path / "none.pem",
        D3PG_TLS_KEY=tmp_path / key,
    )
    assert done.returncode == 2
    assert "cannot speak TLS with D3PG_TLS_CERTIFICATE=" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "data").exists()


def test_a_network_without_tls_is_warned_of(tmp_path: Path) -> None:
    """It is told before anything else, so also by a service that then refuses to start."""
    is_a_file(tmp_path / "data")
    exposed = {"D3PG_HOST": "0.0.0.0", "D3PG_ALLOW_HOST": "lab.example"}  # noqa: S104
    [warning] = [
        line
        for line in started(tmp_path / "data", **exposed).stderr.splitlines()
        if "without TLS" in line
    ]
    assert "D3PG_TLS_CERTIFICATE" in warning
    proxied = {"D3PG_HOST": "0.0.0.0", "D3PG_PUBLIC_URL": "https://lab.example"}  # noqa: S104
    assert "without TLS" not in started(tmp_path / "data", **proxied).stderr


@pytest.mark.parametrize("flags", [[], ["--json"]])
def test_it_says_where_it_is_found(
    app: FastAPI,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    flags: list[str],
) -> None:
    """But for what it starts and what it takes over of its process."""
    for name in ("configure_logging", "serve"):
        monkeypatch.setattr(main_module, name, lambda *_: None)
    monkeypatch.setattr("signal.signal", lambda *_: None)
    monkeypatch.setattr(main_module, "wired", lambda _: nullcontext(app))
    monkeypatch.setattr("sys.argv", ["service", *flags])
    monkeypatch.setenv("D3PG_DATA_DIR", str(tmp_path))
    monkeypatch.setenv("D3PG_PORT", "0")
    assert main_module.main() == 0
    said = capsys.readouterr().out
    found = json.loads(said) if flags else {"link": said.strip()}
    assert re.fullmatch(r"http://127\.0\.0\.1:[1-9]\d+/signin\?code=\S+", found["link"])
    if flags:
        assert found["link"].startswith(found["url"])
        assert found["data_dir"] == str(tmp_path)
