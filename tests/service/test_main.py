"""`python -m service`: a refusal to start is a sentence and exit code 2, and nothing is started."""

import os
import re
import sqlite3
import ssl
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest

from service.data_dir import make_private
from service.listening import listen
from service.store.store import Store
from tests.service.certificate import self_signed

ROOT = Path(__file__).parents[2]


def told(data_dir: Path, settings: Mapping[str, object]) -> dict[str, str]:
    """The environment of a service."""
    own = {"D3PG_DATA_DIR": data_dir, "D3PG_PORT": 0, "PYTHONPATH": ROOT, **settings}
    return os.environ | {name: str(value) for name, value in own.items()}


@contextmanager
def running(data_dir: Path, **settings: object) -> Iterator["subprocess.Popen[str]"]:
    """A service without workers to train, ended with the block."""
    service = subprocess.Popen(
        [sys.executable, "-m", "service"],
        env=told(data_dir, {"D3PG_WORKERS": 1, **settings}),
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield service
    finally:
        service.terminate()
        service.communicate()


def started(data_dir: Path, **settings: object) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-m", "service"],
        env=told(data_dir, settings),
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


@pytest.mark.cluster
def test_what_it_prints_signs_one_browser_in_and_holds_no_token(tmp_path: Path) -> None:
    token = "a-token-of-the-tests-0000"  # noqa: S105
    with running(tmp_path / "data", D3PG_TOKEN=token) as service:
        assert service.stdout is not None
        link = service.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/signin\?code=[\w-]{43}", link)
        with httpx2.Client() as browser:
            assert browser.get(link).status_code == 303
            assert browser.get(link.partition("/signin")[0]).status_code == 200
        assert httpx2.get(link).status_code == 401
        arguments = Path(f"/proc/{service.pid}/cmdline").read_text()
    assert token not in arguments + link


@pytest.mark.cluster
def test_it_speaks_tls_with_a_certificate_of_one_s_own(tmp_path: Path) -> None:
    chain, key = self_signed(tmp_path, "IP:127.0.0.1")
    with running(tmp_path / "data", D3PG_TLS_CERTIFICATE=chain, D3PG_TLS_KEY=key) as service:
        assert service.stdout is not None
        link = service.stdout.readline().strip()
        assert link.startswith("https://127.0.0.1:")
        trust = ssl.create_default_context(cafile=chain)
        with httpx2.Client(verify=trust) as browser:
            signed_in = browser.get(link)
        assert "Secure" in signed_in.headers["set-cookie"]
        assert "strict-transport-security" not in signed_in.headers, "nobody named its address"


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
